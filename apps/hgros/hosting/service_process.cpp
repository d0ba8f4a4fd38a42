#include "hosting/service_process.hpp"

#include <poll.h>
#include <stdio.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/names.hpp"
#include "hosting/component_reports.hpp"
#include "hosting/end_notice.hpp"
#include "hosting/hosted_components.hpp"
#include "hosting/service_notices.hpp"
#include "launch/host_networks.hpp"
#include "launch/robot_graph.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"
#include "trial/component_trial.hpp"

namespace hgros::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kSubscriberPatience{10};
constexpr std::chrono::milliseconds kSubscriberSlice{50};

// Writes the log to standard error, at once: nothing is lost if the process crashes. Remembers which components have
// ended by themselves.
class ServiceLog final : public ComponentReports {
 public:
  ServiceLog(const RobotFile& robot, const RobotProcess& process)
      : robot_(robot), process_(process), wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  ~ServiceLog() override { close(wakes_); }

  void Tell(const RunReport& report) override;
  void Line(std::string_view component, LogLevel level, std::string_view text) override;
  void Wake() noexcept override {
    const std::uint64_t one = 1;
    (void)!write(wakes_, &one, sizeof one);
  }
  void Flush() noexcept override {}
  [[nodiscard]] bool full() override { return false; }

  /// Readable after Wake().
  [[nodiscard]] int wakes() const noexcept { return wakes_; }
  void Slept() noexcept {
    std::uint64_t ignored = 0;
    (void)!read(wakes_, &ignored, sizeof ignored);
  }
  /// The exit code for systemd, if the process must end because of a component.
  [[nodiscard]] std::optional<int> End() {
    const std::scoped_lock lock(mutex_);
    return end_;
  }

 private:
  const RobotFile& robot_;
  const RobotProcess& process_;
  const int wakes_;
  const bool journal_ = std::getenv("JOURNAL_STREAM") != nullptr;
  std::mutex mutex_;
  std::set<std::string> told_;  // Components whose end was logged. Guarded by mutex_, as the rest.
  std::optional<int> end_;
};

// The journal gets the level as a prefix, as sd-daemon(3) has it.
void ServiceLog::Line(std::string_view component, LogLevel level, std::string_view text) {
  static constexpr std::array<std::string_view, 4> kPrefixes{"<7>", "<6>", "<4>", "<3>"};  // By LogLevel.
  static constexpr std::array<std::string_view, 4> kWords{"debug: ", "", "warning: ", "error: "};
  if (level == LogLevel::kDebug) return;
  const auto at = static_cast<std::size_t>(level);
  std::string line(journal_ ? kPrefixes.at(at) : "");
  if (!component.empty()) line += Visible(component) + ": ";
  line += std::string(journal_ ? "" : kWords.at(at)) + Visible(text) + "\n";
  (void)!write(STDERR_FILENO, line.data(), line.size());  // One call: lines of threads are not mixed.
}

void ServiceLog::Tell(const RunReport& report) {
  if (!report.has_component()) return;  // States and parameters are kept where the components are.
  const RunReport::Component& component = report.component();
  const auto state = static_cast<ComponentState>(component.state());
  const bool failed = state == ComponentState::kFailed;
  const std::string why = component.sentence().empty() ? "." : ": " + component.sentence();
  if (component.again()) {
    return Line(component.name(), LogLevel::kError, "It is constructed again, because it has failed" + why);
  }
  {
    const std::scoped_lock lock(mutex_);
    if (state == ComponentState::kRunning) told_.erase(component.name());
    if (!failed && state != ComponentState::kFinished) return;
    if (!told_.insert(component.name()).second) return;
    const RobotComponent* setup = robot_.FindComponent(component.name());
    if (setup != nullptr && setup->essential) {
      end_ = std::max<int>(end_.value_or(0), failed ? kEssentialFailed : kEssentialFinished);
    } else if (failed && process_.restart != RestartPolicy::kNever) {
      end_ = std::max(end_.value_or(0), 1);
    }
  }
  Line(component.name(), failed ? LogLevel::kError : LogLevel::kInfo,
       (failed ? "It has failed" : "It has finished") + why);
}

class Service {
 public:
  Service(const RobotFile& robot, const RobotProcess& process, Pause& pause)
      : robot_(robot), process_(process), pause_(pause), log_(robot, process) {}

  int Run(const ComponentCatalog& catalog);

 private:
  using Outputs = std::map<std::string, std::size_t>;

  [[nodiscard]] RobotGraph Graph(const ComponentCatalog& catalog) const;
  void AwaitSubscribers(Session& session, const Outputs& outputs);
  // Until the process must end. Returns the exit code.
  [[nodiscard]] int Serve(Session& session, HostedComponents& components);
  void Await(Clock::time_point deadline) const;

  const RobotFile& robot_;
  const RobotProcess& process_;
  Pause& pause_;
  ServiceLog log_;
  const ServiceNotices notices_;
};

// It forks: no thread before this. A component of another process that cannot be constructed is a fault of that one.
RobotGraph Service::Graph(const ComponentCatalog& catalog) const {
  std::vector<ComponentSetup> setups;
  for (const RobotComponent& one : robot_.components) setups.push_back(one.setup);
  std::vector<ComponentDescription> descriptions;
  for (TriedComponent& one : TryComponents(setups, catalog, pause_)) {
    if (one.description) descriptions.push_back(*std::move(one.description));
  }
  return {robot_, std::move(descriptions)};
}

void Service::AwaitSubscribers(Session& session, const Outputs& outputs) {
  const auto deadline = Clock::now() + kSubscriberPatience;
  std::string lacks;
  for (const auto& [channel, subscribers] : outputs) {
    while (!session.WaitForSubscribers(channel, subscribers, kSubscriberSlice)) {
      if (pause_.signal() != 0) return;
      if (Clock::now() < deadline) continue;
      lacks += (lacks.empty() ? "" : ", ") + channel;
      break;
    }
  }
  if (lacks.empty()) return;
  log_.Line({}, LogLevel::kWarning,
            "Not all subscribers of " + lacks +
                " were connected after 10 s. The process starts without them; they miss the first messages.");
}

void Service::Await(Clock::time_point deadline) const {
  std::array<pollfd, 2> watched{pollfd{pause_.ended(), POLLIN, 0}, pollfd{log_.wakes(), POLLIN, 0}};
  timespec time{};
  if (deadline != Clock::time_point::max()) {
    const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
    time.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(left).count();
    time.tv_nsec = std::chrono::nanoseconds(left % std::chrono::seconds(1)).count();
  }
  (void)ppoll(watched.data(), watched.size(), deadline == Clock::time_point::max() ? nullptr : &time, nullptr);
}

int Service::Serve(Session& session, HostedComponents& components) {
  const auto period = notices_.watchdog() / 2;
  Clock::time_point due = period.count() > 0 ? Clock::now() : Clock::time_point::max();
  while (pause_.signal() == 0) {
    log_.Slept();
    if (const std::optional<int> code = log_.End())
      return notices_.heard() ? *code : *code == kEssentialFinished ? 0 : 1;
    if (components.AllEnded()) break;
    const Clock::time_point work = components.Work();
    if (due <= Clock::now()) {
      (void)session.Peers();  // A session that hangs does not answer, and then neither does this process.
      notices_.Tell("WATCHDOG=1");
      due = Clock::now() + period;
    }
    Await(std::min(due, work));
  }
  return components.AnyFailed() ? 1 : 0;
}

int Service::Run(const ComponentCatalog& catalog) {
  notices_.TellStatus("Looking at the robot's processes.");
  const RobotGraph graph = Graph(catalog);
  const RobotFile here = PartOfHost(robot_, process_.host, HostNetworks(robot_, graph));
  const RobotProcess& process = *here.FindProcess(process_.name);
  notices_.TellStatus("Constructing components.");
  Session session(process.config, {.name = process.name, .log = [this](LogLevel level, std::string_view text) {
                                     log_.Line({}, level, text);
                                   }});
  const KeptComponents nothing_kept;
  HostedComponents components(session, log_, here, process, nothing_kept);
  const EndNotice notice(pause_.ended(), [&] { components.components().BeginEnd(); });
  components.Construct(catalog);
  components.Join();
  notices_.TellStatus("Waiting for subscribers.");
  AwaitSubscribers(session, graph.SubscribersOf(process_));
  if (pause_.signal() == 0) {
    components.Start();
    notices_.Tell("READY=1");
    notices_.TellStatus("Running.");
  }
  const int code = Serve(session, components);
  notices_.Tell("STOPPING=1");
  return code;
}

}  // namespace

int RunAsService(const RobotFile& robot, std::string_view process, const ComponentCatalog& catalog, Pause& pause) {
  const RobotProcess* found = robot.FindProcess(process);
  if (found == nullptr) {
    std::vector<std::string> names;
    for (const RobotProcess& one : robot.processes) names.push_back(one.name);
    const std::string nearest = NearestName(process, names);
    throw Error(
        "The robot has no process \"" + std::string(process) + "\".", {},
        nearest.empty() ? "A program of the robot runs by its own command." : "Did you mean \"" + nearest + "\"?");
  }
  (void)setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // What components print is seen at once.
  return Service(robot, *found, pause).Run(catalog);
}

}  // namespace hgros::cli
