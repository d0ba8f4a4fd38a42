#include "launch/hosted_process.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "hgros/component/components.hpp"
#include "launch/run.pb.h"
#include "processes/message_stream.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostUnsentBytes = 1U << 20U;
constexpr std::chrono::seconds kJoinPatience{10};
constexpr std::chrono::milliseconds kJoinSlice{50};

// What the process tells its starter. A starter that does not read must not stop the robot: lines are then lost, and
// counted.
//
// Thread safety: all functions.
class Reporter {
 public:
  explicit Reporter(int socket) : stream_(socket), wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;
  ~Reporter() { close(wakes_); }

  void Tell(const RunReport& report) {
    const std::scoped_lock lock(mutex_);
    if (report.has_line() && stream_.unsent() > kMostUnsentBytes) {
      ++lost_;
      return;
    }
    TellLost();
    stream_.Add(report);
    if (stream_.Write() && stream_.unsent() > 0) Wake();
  }
  void Stage(RunReport::Stage stage) {
    RunReport report;
    report.set_stage(stage);
    Tell(report);
  }
  void Fault(const std::string& what) {
    RunReport report;
    report.set_fault(what);
    Tell(report);
  }
  void Line(std::string_view component, LogLevel level, std::string_view text) {
    RunReport report;
    RunReport::Line& line = *report.mutable_line();
    line.set_component(std::string(component));
    line.set_level(static_cast<int>(level));
    line.set_text(std::string(text));
    line.set_time_ns(std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
    Tell(report);
  }

  [[nodiscard]] int socket() const noexcept { return stream_.descriptor(); }
  // Readable after Wake(), and once something waits to be written.
  [[nodiscard]] int wakes() const noexcept { return wakes_; }
  void Wake() noexcept {
    const std::uint64_t one = 1;
    (void)!write(wakes_, &one, sizeof one);
  }
  void Slept() noexcept {
    std::uint64_t ignored = 0;
    (void)!read(wakes_, &ignored, sizeof ignored);
  }
  void Write() {
    const std::scoped_lock lock(mutex_);
    (void)stream_.Write();
    TellLost();
  }
  [[nodiscard]] bool unsent() {
    const std::scoped_lock lock(mutex_);
    return stream_.unsent() > 0;
  }
  // Orders. On one thread; the stream's two directions share nothing.
  [[nodiscard]] bool Read() { return stream_.Read(); }
  [[nodiscard]] bool Next(RunOrder& order) { return stream_.Next(order); }

 private:
  // As soon as there is room again.
  void TellLost() {
    if (lost_ == 0 || stream_.unsent() > kMostUnsentBytes) return;
    RunReport lost;
    lost.set_lost(std::exchange(lost_, 0));
    stream_.Add(lost);
  }

  std::mutex mutex_;
  MessageStream stream_;
  const int wakes_;
  std::uint64_t lost_ = 0;
};

// The process between two orders.
class Host {
 public:
  Host(Reporter& reporter, Pause& pause, const RobotFile& robot, const RobotProcess& process)
      : reporter_(reporter), pause_(pause), robot_(robot), process_(process) {}

  int Run(const ComponentCatalog& catalog);

 private:
  void Construct(Components& components, const ComponentCatalog& catalog);
  void Obey(Session& session, Components& components, const RunOrder& order);
  void Join(Session& session, Components& components, const RunOrder::Join& join);
  void Note(const ComponentStatus& status);
  void Await();
  // All have finished or failed.
  [[nodiscard]] bool AllEnded();

  Reporter& reporter_;
  Pause& pause_;
  const RobotFile& robot_;
  const RobotProcess& process_;
  bool ends_ = false;

  std::mutex mutex_;
  std::map<std::string, ComponentState> states_;  // Guarded by mutex_.
};

void Host::Note(const ComponentStatus& status) {
  RunReport report;
  RunReport::Component& component = *report.mutable_component();
  component.set_name(status.name);
  component.set_state(static_cast<int>(status.state));
  component.set_sentence(status.sentence);
  component.set_exceptions(status.exceptions);
  {
    const std::scoped_lock lock(mutex_);
    states_[status.name] = status.state;
  }
  reporter_.Tell(report);
  reporter_.Wake();
}

bool Host::AllEnded() {
  const std::scoped_lock lock(mutex_);
  return !states_.empty() && std::ranges::all_of(states_, [](const auto& one) {
    return one.second == ComponentState::kFinished || one.second == ComponentState::kFailed;
  });
}

void Host::Construct(Components& components, const ComponentCatalog& catalog) {
  for (const std::string& name : process_.components) {
    const RobotComponent& component = *robot_.FindComponent(name);
    (void)catalog.Load(component.setup.type);
    {
      const std::scoped_lock lock(mutex_);
      states_[name] = ComponentState::kWired;
    }
    (void)components.Add(component.setup);
  }
}

void Host::Join(Session& session, Components& components, const RunOrder::Join& join) {
  components.Join();
  const auto deadline = std::chrono::steady_clock::now() + kJoinPatience;
  std::string lacks;
  for (const RunOrder::Output& output : join.outputs()) {
    while (!session.WaitForSubscribers(output.channel(), output.subscribers(), kJoinSlice)) {
      if (pause_.signal() != 0) return;
      if (std::chrono::steady_clock::now() < deadline) continue;
      lacks += (lacks.empty() ? "" : ", ") + output.channel();
      break;
    }
  }
  if (!lacks.empty()) {
    RunReport report;
    report.set_lacks(lacks);
    reporter_.Tell(report);
  }
  reporter_.Stage(RunReport::JOINED);
}

void Host::Obey(Session& session, Components& components, const RunOrder& order) {
  if (order.has_join()) {
    Join(session, components, order.join());
  } else if (order.has_start()) {
    components.Start();
    reporter_.Stage(RunReport::RUNNING);
  } else {
    ends_ = true;
  }
}

// Until there is an order, a component has changed, or the process shall end.
void Host::Await() {
  if (pause_.signal() != 0) return;
  const auto events = static_cast<short>(reporter_.unsent() ? POLLIN | POLLOUT : POLLIN);
  std::array<pollfd, 3> watched{pollfd{reporter_.socket(), events, 0}, pollfd{reporter_.wakes(), POLLIN, 0},
                                pollfd{pause_.ended(), POLLIN, 0}};
  if (poll(watched.data(), watched.size(), -1) < 0) {
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
  Components components(session, {.log = [this](std::string_view component, LogLevel level,
                                                std::string_view text) { reporter_.Line(component, level, text); },
                                  .on_change = [this](const ComponentStatus& status) { Note(status); }});
  Construct(components, catalog);
  reporter_.Stage(RunReport::CONSTRUCTED);
  while (!ends_ && pause_.signal() == 0 && !AllEnded()) {
    RunOrder order;
    while (!ends_ && reporter_.Next(order)) Obey(session, components, order);
    if (!ends_ && !AllEnded()) Await();
  }
  const std::scoped_lock lock(mutex_);
  return std::ranges::any_of(states_, [](const auto& one) { return one.second == ComponentState::kFailed; }) ? 1 : 0;
}

}  // namespace

int HostComponents(int socket, const RobotFile& robot, const RobotProcess& process, const ComponentCatalog& catalog) {
  Pause pause;
  Reporter reporter(socket);
  try {
    return Host(reporter, pause, robot, process).Run(catalog);
  } catch (const std::exception& error) {
    reporter.Fault(error.what());
    return 1;
  }
}

}  // namespace hgros::cli
