// The cost of a call: alone, after pauses in which every thread falls asleep, and with many in flight.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "hgros/hgros.hpp"
#include "support/handoff.hpp"
#include "support/receiver_process.hpp"

namespace hgros::bench {
namespace {

struct Kilobyte {
  std::array<char, 1024> bytes{};
};

constexpr auto kPatience = std::chrono::seconds(10);

std::string Yaml(const std::string& scheme, const std::string& own, const std::string& other) {
  if (scheme != "tcp") return "";
  return "network: {publisher: {ip: '" + own + "'}, subscribers: [{ip: '" + other + "'}]}\ndiscovery: {local: false}\n";
}

void ServeOn(Session& session, std::vector<Service>& services) {
  const auto echo = [](const Kilobyte& request) { return request; };
  services.push_back(
      session.Serve<Kilobyte, Kilobyte>("inline", echo, Invoke::kConcurrent, {.executor = Executor::Inline()}));
  services.push_back(session.Serve<Kilobyte, Kilobyte>("tbb", echo, Invoke::kConcurrent));
}

// The other process: this program, started again.
int ServerMain(const std::string& yaml) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Session session(Config::Parse(yaml), {"server"});
  std::vector<Service> services;
  ServeOn(session, services);
  for (;;) pause();
}

class ServerProcess {
 public:
  explicit ServerProcess(const std::string& yaml) : pid_(fork()) {
    if (pid_ != 0) return;
    execl("/proc/self/exe", "bench_services", "server", yaml.c_str(), nullptr);
    _exit(127);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;
  ~ServerProcess() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

 private:
  pid_t pid_;
};

// A caller and the session that serves its calls.
class Side {
 public:
  explicit Side(const std::string& scheme) : name(scheme) {
    const std::string port = std::to_string(26000 + getpid() % 1000 * 2);
    const std::string a = "tcp://127.0.0.1:" + port, b = "tcp://127.0.0.1:" + std::to_string(std::stoi(port) + 1);
    if (scheme != "inprocess") server_.emplace(Yaml(scheme, b, a));
    session.emplace(Config::Parse(Yaml(scheme, a, b)), SessionOptions{"caller"});
    if (scheme == "inprocess") ServeOn(*session, services_);
    for (const char* service : {"inline", "tbb"}) {
      while (!session->Call<Kilobyte, Kilobyte>(service, Kilobyte{}, kPatience).Wait()) {
      }
    }
  }
  const std::string name;
  std::optional<Session> session;

 private:
  std::optional<ServerProcess> server_;
  std::vector<Service> services_;
};

// Round trips with a future that the measuring thread waits for, in ns.
Samples Futures(Side& side, const std::string& service, int count, std::chrono::microseconds pause) {
  Samples samples;
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_for(pause);
    auto request = std::make_unique<Kilobyte>();
    const std::int64_t start = MonotonicNow();
    if (!side.session->Call<Kilobyte, Kilobyte>(service, std::move(request), kPatience).Wait()) continue;
    samples.Add(static_cast<double>(MonotonicNow() - start));
  }
  return samples;
}

// Likewise until the beginning of a callback.
Samples Callbacks(Side& side, const std::string& service, int count, std::chrono::microseconds pause) {
  Arrival arrival;
  return MeasureLatency(count, pause, arrival, [&] {
    side.session->Call<Kilobyte, Kilobyte>(service, std::make_unique<Kilobyte>(), kPatience,
                                           [&](const CallResult<Kilobyte>&) { arrival.Note(); });
  });
}

// Calls per second with up to 64 in flight.
double Rate(Side& side, const std::string& service, int count) {
  std::mutex mutex;
  std::condition_variable changed;
  int under_way = 0;
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) {
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return under_way < 64; });
      ++under_way;
    }
    side.session->Call<Kilobyte, Kilobyte>(service, std::make_unique<Kilobyte>(), kPatience,
                                           [&](const CallResult<Kilobyte>&) {
                                             const std::scoped_lock lock(mutex);
                                             --under_way;
                                             changed.notify_one();
                                           });
  }
  std::unique_lock lock(mutex);
  changed.wait(lock, [&] { return under_way == 0; });
  return count / (static_cast<double>(MonotonicNow() - start) / 1e9);
}

void Measure(const std::string& scheme, int rounds, int each, int flood) {
  Side side(scheme);
  std::optional<ReceiverProcess> receiver;
  std::unique_ptr<PairSender> sender;
  BlockPool pool(1024, 64);
  if (scheme == "shm") {
    const ReceiverTask task{"ours", "domain:bench-one-way-" + std::to_string(getpid()), "inline", false};
    receiver.emplace(task);
    sender = MakeSender(task, task.endpoint);
    AwaitConnection(receiver->control(), *sender);
  }
  const auto pause = std::chrono::microseconds(2000);
  Samples one_way, ratio, future, callback, worker, rate;
  for (int round = 0; round < rounds; ++round) {
    const Samples now = Futures(side, "inline", each, pause);
    future.Add(now);
    callback.Add(Callbacks(side, "inline", each, pause));
    worker.Add(Futures(side, "tbb", each / 2, pause));
    rate.Add(Rate(side, "tbb", flood));
    if (!sender) continue;
    const Samples message = MeasurePair(receiver->control(), *sender, pool, each, 2000);
    one_way.Add(message);
    ratio.Add(now.Median() / message.Median());
  }
  ReportLatency(scheme + "_round_trip", future);
  ReportLatency(scheme + "_round_trip_to_callback", callback);
  ReportLatency(scheme + "_round_trip_tbb", worker);
  Report(scheme + "_calls_per_s", rate.Median(), "1/s");
  if (!sender) return;
  ReportLatency("shm_one_way", one_way);
  Report("shm_round_trip_over_one_way", ratio.Median(), "ratio");
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  using namespace hgros::bench;
  if (const int code = ReceiverMain(argc, argv); code >= 0) return code;
  if (argc > 2 && std::strcmp(argv[1], "server") == 0) return ServerMain(argv[2]);
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  setenv("HGROS_DOMAIN", ("bench-services-" + std::to_string(getpid())).c_str(), 1);
  for (const char* scheme : {"inprocess", "shm", "tcp"}) {
    Measure(scheme, quick ? 5 : 25, quick ? 21 : 100, quick ? 5'000 : 50'000);
  }
  return 0;
}
