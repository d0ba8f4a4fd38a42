// A program that ends inside a callback of its session while other callbacks run.
//
//   --session=static|main|default  who owns the session
//   --end=exit|destroy|thread      what the callback does: exit(7), destroy the session (then main returns 7), or
//                                  pthread_exit()
//   --in=KIND                      the callback: tbb, inline, dedicated, timer, inline-timer, service, peer-event,
//                                  remote (inline, on a thread of the transport), remote-tbb, outside (tbb; another
//                                  process publishes on "fatal"), or wiring (tbb; another thread subscribes and serves
//                                  until the process has ended)
//   --bus=FOLDER                   for ipc endpoints
//
// Writes "ending", and then "static object ended", to standard output.
#include <pthread.h>
#include <sys/prctl.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/worker_program.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;
using test::Await;

constexpr int kStatus = 7;
constexpr int kLateStatus = 8;  // A callback has started after the end of the session.

std::atomic<bool> wires{false};
std::atomic<bool> exits{false};

struct StaticObject {
  ~StaticObject() {
    Say("static object ended");
    exits = true;
    if (wires) test::Linger(std::chrono::milliseconds(100));
  }
};
StaticObject static_object;
std::unique_ptr<Session> static_session;
std::atomic<bool> ended{false};
std::mutex held;

class Program {
 public:
  explicit Program(const Arguments& arguments)
      : owner_(arguments.Text("session")),
        end_(arguments.Text("end")),
        kind_(arguments.Text("in")),
        bus_(arguments.Text("bus")) {}

  int Run() {
    Start();
    Session& session = Subject();
    const auto busy = session.Advertise<Log>("busy");
    for (int i = 0; i < 3; ++i) {
      nodes_.push_back(session.FromAny<Log>("busy", i == 0 ? Invoke::kConcurrent : Invoke::kSerial,
                                            [](const Log& log) { Work(log); }));
    }
    Wire(session);
    while (!ended) (void)busy(std::make_unique<Log>());
    return kStatus;
  }

 private:
  static void Work(const Log& log) {
    const std::scoped_lock lock(held);
    (void)log.SerializeAsString();
  }

  [[nodiscard]] Config ConfigOf(const std::string& mine, const std::string& theirs) const {
    return Config::Parse("{data_graph: {threads: 4}, network: {publisher: {ip: \"ipc://" + bus_ + "/" + mine +
                         "\"}, subscribers: [{ip: \"ipc://" + bus_ + "/" + theirs + "\"}]}}");
  }

  void Start() {
    Config config = ConfigOf("subject", "other");
    if (owner_ == "default") return Init(std::move(config), {"subject"});
    auto session = std::make_unique<Session>(std::move(config), SessionOptions{"subject"});
    (owner_ == "static" ? static_session : main_session_) = std::move(session);
  }

  [[nodiscard]] Session& Subject() const {
    if (owner_ == "default") return DefaultSession();
    return owner_ == "static" ? *static_session : *main_session_;
  }

  void End() {
    const std::unique_lock lock = kind_ == "locked" ? std::unique_lock(held) : std::unique_lock<std::mutex>();
    Say("ending");
    if (end_ == "exit") std::exit(kStatus);
    if (end_ == "thread") pthread_exit(nullptr);
    if (owner_ == "default") {
      Shutdown();
    } else {
      (owner_ == "static" ? static_session : main_session_).reset();
    }
    ended = true;
  }

  void Wire(Session& session) {
    NodeOptions options{"fatal", {}, {}};
    if (kind_ == "inline" || kind_ == "remote" || kind_ == "peer-event") options.executor = Executor::Inline();
    if (kind_ == "dedicated") options.executor = Executor::Dedicated();
    if (kind_ == "timer" || kind_ == "inline-timer") {
      NodeTimerOptions timed;
      if (kind_ == "inline-timer") timed.executor = Executor::Inline();
      timer_.emplace(session.CreateTimer(
          "fatal", std::chrono::milliseconds(20), [this](const Tick&) { End(); }, timed));
    } else if (kind_ == "service") {
      service_.emplace(session.Serve<Log, Log>("fatal", [this](const Log& log) {
        End();
        return log;
      }));
      (void)session.Call<Log, Log>("fatal", Log(), test::kPatience, [](const CallResult<Log>&) {});
    } else if (kind_ == "peer-event") {
      nodes_.push_back(session.FromGraph<PeerEvent>(
          kPeerEventsChannel, Invoke::kSerial, [this](const PeerEvent&) { End(); }, options));
      Connect();
    } else {
      nodes_.push_back(session.FromAny<Log>(
          "fatal", Invoke::kSerial, [this](const Log&) { End(); }, options));
      if (kind_ == "remote" || kind_ == "remote-tbb") {
        Connect();
        auto& other = *other_;
        (void)other.Advertise<Log>("fatal");
        thread_ = std::jthread([&other] {
          if (!other.WaitForSubscribers("fatal", 1, test::kPatience)) return;
          while (!ended) (void)other.ToAny("fatal", Log());
        });
      } else if (kind_ != "outside") {
        if (kind_ == "wiring") {
          std::thread([&session] { KeepWiring(session); }).detach();
          if (!Await([] { return wires.load(); })) return;
        }
        thread_ = std::jthread([publish = session.Advertise<Log>("fatal")] { (void)publish(std::make_unique<Log>()); });
      }
    }
  }

  static void KeepWiring(Session& session) {
    wires = true;
    for (;;) {
      if (exits) session.AddSubscriberEndpoint({"ipc:///tmp/nobody", {}, true});
      const auto late = session.FromGraph<Log>("late", Invoke::kSerial, [](const Log&) {
        if (exits) std::_Exit(kLateStatus);
      });
      (void)session.ToGraph("late", std::make_unique<Log>());
      const auto service = session.Serve<Log, Log>("late", [](const Log& log) { return log; });
    }
  }

  void Connect() { other_ = std::make_unique<Session>(ConfigOf("other", "subject"), SessionOptions{"other"}); }

  const std::string owner_;
  const std::string end_;
  const std::string kind_;
  const std::string bus_;
  std::unique_ptr<Session> other_;
  std::unique_ptr<Session> main_session_;
  std::vector<Subscription> nodes_;
  std::optional<NodeTimer> timer_;
  std::optional<Service> service_;
  std::jthread thread_;
};

}  // namespace
}  // namespace hgros::resilience

int main(int count, char** texts) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  return hgros::resilience::Program({count, texts}).Run();
}
