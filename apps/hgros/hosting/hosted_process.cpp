#include "hosting/hosted_process.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <set>
#include <string>

#include "hosting/component_moves.hpp"
#include "hosting/end_notice.hpp"
#include "hosting/hosted_components.hpp"
#include "hosting/reporter.hpp"
#include "launch/run.pb.h"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kJoinPatience{10};
constexpr std::chrono::milliseconds kJoinSlice{50};

// The process between two orders.
class Host {
 public:
  Host(Reporter& reporter, Pause& pause, const RobotFile& robot, const RobotProcess& process,
       const KeptComponents& kept)
      : reporter_(reporter), pause_(pause), robot_(robot), process_(process), kept_(kept) {}

  int Run(const ComponentCatalog& catalog);

 private:
  void Obey(Session& session, HostedComponents& components, const RunOrder& order);
  void Join(Session& session, HostedComponents& components, const RunOrder::Join& join);
  // Adds what has too few after a while to `lacks`. False: the process ends.
  bool AwaitSubscribers(Session& session, HostedComponents& components, const std::string& channel, std::uint64_t count,
                        Clock::time_point deadline, std::set<std::string>& lacks);
  void Await(Clock::time_point until);

  Reporter& reporter_;
  Pause& pause_;
  const RobotFile& robot_;
  const RobotProcess& process_;
  const KeptComponents& kept_;
  ComponentMoves* moves_ = nullptr;  // While the session lives.
  bool ends_ = false;
};

bool Host::AwaitSubscribers(Session& session, HostedComponents& components, const std::string& channel,
                            std::uint64_t count, Clock::time_point deadline, std::set<std::string>& lacks) {
  while (!session.WaitForSubscribers(channel, count, kJoinSlice)) {
    if (pause_.signal() != 0 || !reporter_.Read()) return false;
    RunOrder next;
    if (reporter_.Next(next)) Obey(session, components, next);
    if (ends_) return false;
    if (Clock::now() < deadline) continue;
    lacks.insert(channel);
    break;
  }
  return true;
}

void Host::Join(Session& session, HostedComponents& components, const RunOrder::Join& join) {
  const auto deadline = Clock::now() + kJoinPatience;
  std::set<std::string> lacks;
  // In a robot that runs, messages arrive as soon as the inputs join. What callbacks publish then shall reach the other
  // processes that run.
  for (const RunOrder::Output& output : join.outputs()) {
    if (!AwaitSubscribers(session, components, output.channel(), output.ready(), deadline, lacks)) return;
  }
  components.Join();
  for (const RunOrder::Output& output : join.outputs()) {
    if (!AwaitSubscribers(session, components, output.channel(), output.subscribers(), deadline, lacks)) return;
  }
  if (!lacks.empty()) {
    std::string all;
    for (const std::string& one : lacks) all += (all.empty() ? "" : ", ") + one;
    RunReport report;
    report.set_lacks(all);
    reporter_.Tell(report);
  }
  reporter_.Stage(RunReport::JOINED);
}

void Host::Obey(Session& session, HostedComponents& components, const RunOrder& order) {
  if (order.has_join()) {
    Join(session, components, order.join());
  } else if (order.has_start()) {
    components.Start();
    reporter_.Stage(RunReport::RUNNING);
  } else if (order.has_move()) {
    moves_->Obey(order.move());
  } else if (order.has_again()) {
    components.ConstructAgain(order.again().component());
  } else {
    ends_ = true;
    if (order.end().save()) {
      components.SaveAll();
      reporter_.Stage(RunReport::SAVED);
    }
    components.components().BeginEnd();
  }
}

// Until there is an order, a component has changed, something is due, or the process shall end.
void Host::Await(Clock::time_point until) {
  if (pause_.signal() != 0) return;
  const auto events = static_cast<short>(reporter_.unsent() > 0 ? POLLIN | POLLOUT : POLLIN);
  std::array<pollfd, 3> watched{pollfd{reporter_.socket(), events, 0}, pollfd{reporter_.wakes(), POLLIN, 0},
                                pollfd{pause_.ended(), POLLIN, 0}};
  int wait_ms = -1;
  if (until != Clock::time_point::max()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    wait_ms = static_cast<int>(std::clamp<std::int64_t>(left, 0, 60'000));
  }
  if (poll(watched.data(), watched.size(), wait_ms) < 0) {
    ends_ = errno != EINTR;
    return;
  }
  if (watched[1].revents != 0) reporter_.Slept();
  if ((watched[0].revents & POLLOUT) != 0) reporter_.Write();
  if ((watched[0].revents & (POLLIN | POLLHUP)) != 0 && !reporter_.Read()) ends_ = true;  // The starter has gone.
}

int Host::Run(const ComponentCatalog& catalog) {
  Session session(process_.config, {.name = process_.name, .log = [this](LogLevel level, std::string_view text) {
                                      reporter_.Line({}, level, text);
                                    }});
  HostedComponents components(session, reporter_, robot_, process_, kept_);
  const EndNotice notice(pause_.ended(), [&] { components.components().BeginEnd(); });
  components.Construct(catalog);
  ComponentMoves moves(session, components, reporter_, robot_, catalog);
  moves_ = &moves;
  reporter_.Stage(RunReport::CONSTRUCTED);
  while (!ends_ && pause_.signal() == 0 && !components.AllEnded()) {
    RunOrder order;
    while (!ends_ && reporter_.Next(order)) Obey(session, components, order);
    const Clock::time_point due = std::min(components.Work(), moves.Work());
    if (!ends_ && !components.AllEnded()) Await(due);
  }
  if (!ends_ && reporter_.Read()) {  // A signal may come with the order to save.
    RunOrder order;
    while (!ends_ && reporter_.Next(order)) {
      if (order.has_end()) Obey(session, components, order);
    }
  }
  return components.AnyFailed() ? 1 : 0;
}

}  // namespace

int HostComponents(int socket, const RobotFile& robot, const RobotProcess& process, const ComponentCatalog& catalog,
                   const KeptComponents& kept) {
  Pause pause;
  Reporter reporter(socket);
  int code = 1;
  try {
    code = Host(reporter, pause, robot, process, kept).Run(catalog);
  } catch (const std::exception& error) {
    reporter.Fault(error.what());
  }
  reporter.Flush();
  return code;
}

}  // namespace hgros::cli
