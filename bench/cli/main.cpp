// The cost of the command hgros: alone, beside a robot of 20 processes, with messages at 1 kHz, its full
// screen beside 50 sessions, and to the robot.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <foxglove/Log.pb.h>

#include "cli/child.hpp"
#include "hgros/hgros.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

using std::chrono::milliseconds;

constexpr int kSessions = 20;
constexpr int kChannelsEach = 10;
const char* const kSelf = "/proc/self/exe";

std::unique_ptr<foxglove::Log> Kilobyte() {
  auto log = std::make_unique<foxglove::Log>();
  log->set_message(std::string(1000, 'x'));
  log->set_name("bench");
  return log;
}

// A process of the robot: ten channels at 10 Hz, and a subscriber for one of the next process.
int RobotMain(int index) {
  Session session(Config(), SessionOptions{"robot" + std::to_string(index)});
  const auto name = [](int session_index, int channel) {
    return "part" + std::to_string(session_index % kSessions) + "/channel" + std::to_string(channel);
  };
  std::vector<Publisher<foxglove::Log>> publish;
  for (int i = 0; i < kChannelsEach; ++i) publish.push_back(session.Advertise<foxglove::Log>(name(index, i)));
  const Subscription next =
      session.FromAny<foxglove::Log>(name(index + 1, 0), Invoke::kSerial, [](const foxglove::Log&) {});
  const NodeTimer timer = session.CreateTimer("publish", milliseconds(100), [&](const Tick&) {
    for (auto& one : publish) one(Kilobyte());
  });
  for (;;) pause();
}

// A small process of a large robot: it publishes at 10 Hz to itself.
int PartMain(int index) {
  const std::string name = "part" + std::to_string(index);
  Session session(Config(), SessionOptions{name});
  const auto publish = session.Advertise<foxglove::Log>(name);
  const Subscription heard = session.FromAny<foxglove::Log>(name, Invoke::kSerial, [](const foxglove::Log&) {});
  const NodeTimer timer = session.CreateTimer("publish", milliseconds(100), [&](const Tick&) { publish(Kilobyte()); });
  for (;;) pause();
}

// Publishes 1 KB at 1 kHz.
int TalkerMain() {
  Session session(Config(), SessionOptions{"talker"});
  const auto publish = session.Advertise<foxglove::Log>("tick");
  const NodeTimer timer = session.CreateTimer("publish", milliseconds(1), [&](const Tick&) { publish(Kilobyte()); });
  for (;;) pause();
}

Samples Times(int count, const std::vector<std::string>& words) {
  Samples samples;
  for (int i = 0; i < count; ++i) samples.Add(RunTime(words));
  return samples;
}

void MeasureStarts(const std::string& hgros, int count) {
  Report("exec_true_ms", Times(count, {"/bin/true"}).Median(), "ms");
  Report("help_ms", Times(count, {hgros, "help"}).Median(), "ms");
}

// Waits until `hgros list` writes that many lines.
void AwaitLines(const std::string& hgros, std::ptrdiff_t lines) {
  const auto written = [&] {
    const std::string out = Child({hgros, "list"}).ReadAll();
    return std::ranges::count(out, '\n');
  };
  while (written() < lines) std::this_thread::sleep_for(milliseconds(100));
}

void MeasureList(const std::string& hgros, int count) {
  setenv("HGROS_DOMAIN", ("bench-cli-list-" + std::to_string(getpid())).c_str(), 1);
  std::vector<std::unique_ptr<Child>> robot;
  for (int i = 0; i < kSessions; ++i) {
    robot.push_back(std::make_unique<Child>(std::vector<std::string>{kSelf, "robot", std::to_string(i)}));
  }
  AwaitLines(hgros, kSessions * kChannelsEach + 1);
  Samples list;
  Samples floor;
  for (int i = 0; i < count; ++i) {
    list.Add(RunTime({hgros, "list"}));
    floor.Add(RunTime({"/bin/true"}));
  }
  Report("list_ms", list.Median(), "ms");
  Report("list_p90_ms", list.Quantile(0.9), "ms");
  Report("exec_true_beside_robot_ms", floor.Median(), "ms");
}

// CPU time of the child over `time`, in percent of one core, and the number of bytes that it writes.
struct Load {
  double cpu_percent = 0;
  std::size_t bytes = 0;
};
Load MeasureLoad(Child& child, std::chrono::nanoseconds time) {
  Load load;
  const std::int64_t cpu = child.CpuTime();
  const std::int64_t start = MonotonicNow();
  while (MonotonicNow() - start < time.count()) load.bytes += child.Read().size();
  const auto taken = static_cast<double>(MonotonicNow() - start);
  load.cpu_percent = 100 * static_cast<double>(child.CpuTime() - cpu) / taken;
  return load;
}

// The full screen with as many sessions as a large robot has, each of one channel and one node.
void MeasureTop(const std::string& hgros, std::chrono::nanoseconds time) {
  setenv("HGROS_DOMAIN", ("bench-cli-top-" + std::to_string(getpid())).c_str(), 1);
  setenv("TERM", "xterm-256color", 1);
  constexpr int kTopSessions = 50;
  std::vector<std::unique_ptr<Child>> robot;
  for (int i = 0; i < kTopSessions; ++i) {
    robot.push_back(std::make_unique<Child>(std::vector<std::string>{kSelf, "part", std::to_string(i)}));
  }
  AwaitLines(hgros, kTopSessions + 1);
  for (const char* list : {"sessions", "nodes"}) {
    Child top({hgros, "top", list}, Child::Place::kTerminal);
    const std::int64_t start = MonotonicNow();
    while (MonotonicNow() - start < 3'000'000'000) (void)top.Read();  // All have answered, and were drawn.
    const Load load = MeasureLoad(top, time);
    const std::string name = list == std::string("sessions") ? "top" : "top_nodes";
    Report(name + "_cpu_percent", load.cpu_percent, "%");
    Report(name + "_kb_per_s", static_cast<double>(load.bytes) / static_cast<double>(time.count()) * 1e6, "KB/s");
  }
}

void MeasureEcho(const std::string& hgros, std::chrono::nanoseconds time) {
  setenv("HGROS_DOMAIN", ("bench-cli-echo-" + std::to_string(getpid())).c_str(), 1);
  const Child talker({kSelf, "talker"});
  AwaitLines(hgros, 2);
  std::string message;
  for (const bool json : {false, true}) {
    std::vector<std::string> words{hgros, "echo", "tick", "--full"};
    if (json) words.emplace_back("--json");
    Child echo(words);
    while (message.size() < 1000) message += echo.Read();  // It has found the talker.
    const Load load = MeasureLoad(echo, time);
    const double seconds = static_cast<double>(time.count()) / 1e9;
    Report(json ? "echo_json_1khz_cpu_percent" : "echo_1khz_cpu_percent", load.cpu_percent, "%");
    Report(json ? "echo_json_1khz_kb_per_s" : "echo_1khz_kb_per_s", static_cast<double>(load.bytes) / seconds / 1e3,
           "KB/s");
  }
  Child cat({"/bin/cat"});
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    const std::string bytes(1070, 'x');
    for (auto next = std::chrono::steady_clock::now(); !stop; std::this_thread::sleep_until(next)) {
      cat.Write(bytes);
      next += milliseconds(1);
    }
  });
  (void)cat.Read();
  Report("cat_1khz_cpu_percent", MeasureLoad(cat, time).cpu_percent, "%");
  stop = true;
  writer.join();
}

// What a thread publishes to a node of its own process.
struct Published {
  double per_second = 0;
  double cpu_ns = 0;  // Of this process per message, with what it does for observers.
};
Published Publish(const Publisher<foxglove::Log>& publish, std::chrono::nanoseconds time) {
  const auto cpu_now = [] {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return now.tv_sec * 1'000'000'000 + now.tv_nsec;
  };
  const std::int64_t cpu = cpu_now();
  const std::int64_t start = MonotonicNow();
  std::int64_t now = start;
  std::uint64_t count = 0;
  for (; now - start < time.count(); now = MonotonicNow()) {
    for (int i = 0; i < 100; ++i, ++count) publish(std::make_unique<foxglove::Log>());
  }
  const auto messages = static_cast<double>(count);
  return {messages * 1e9 / static_cast<double>(now - start), static_cast<double>(cpu_now() - cpu) / messages};
}

// Rounds with and without an observer take turns, so that what else the machine does meets both.
void MeasureObserver(const std::string& hgros, int rounds) {
  setenv("HGROS_DOMAIN", ("bench-cli-hz-" + std::to_string(getpid())).c_str(), 1);
  Session session(Config(), SessionOptions{"publisher"});
  const auto publish = session.Advertise<foxglove::Log>("tick");
  std::uint64_t heard = 0;
  const Subscription subscription = session.FromAny<foxglove::Log>(
      "tick", Invoke::kSerial, [&](const foxglove::Log&) { ++heard; }, {.executor = Executor::Inline()});
  constexpr milliseconds kTime{1000};  // As long as from one snapshot to the next.
  (void)Publish(publish, kTime);
  Samples beside;
  Samples cpu;
  Samples alone;
  Samples hz_cpu;
  for (int i = 0; i < rounds; ++i) {
    Published with;
    Published without;
    for (const bool observed : {i % 2 == 0, i % 2 != 0}) {
      if (!observed) {
        without = Publish(publish, kTime);
        continue;
      }
      Child hz({hgros, "hz", "tick"});
      (void)hz.Read();  // It runs.
      const std::int64_t before = hz.CpuTime();
      with = Publish(publish, kTime);
      hz_cpu.Add(static_cast<double>(hz.CpuTime() - before) / 1e9 * 100);
    }
    beside.Add(with.per_second);
    cpu.Add(with.cpu_ns / without.cpu_ns);
    alone.Add(without.per_second);
  }
  Report("publish_per_s", alone.Median(), "1/s");
  // The rounds that other programs disturbed least. By CPU time all rounds count.
  Report("observer_cost_ratio", alone.Quantile(0.9) / beside.Quantile(0.9), "ratio");
  Report("observer_cpu_ratio", cpu.Median(), "ratio");
  Report("hz_cpu_percent", hz_cpu.Median(), "%");
}

void MeasureSize(const std::string& hgros) {
  const char* folder = std::getenv("TMPDIR");
  const std::string stripped = std::string(folder == nullptr ? "/tmp" : folder) + "/hgros_stripped";
  (void)RunTime({"/usr/bin/strip", "-o", stripped, hgros});
  struct stat status {};
  if (stat(stripped.c_str(), &status) != 0) return;
  Report("binary_mb", static_cast<double>(status.st_size) / 1e6, "MB");
  (void)unlink(stripped.c_str());
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  using namespace hgros::bench;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty()) return 2;
  if (words[0] == "robot" && words.size() > 1) return RobotMain(std::stoi(words[1]));
  if (words[0] == "part" && words.size() > 1) return PartMain(std::stoi(words[1]));
  if (words[0] == "talker") return TalkerMain();
  const bool quick = words.size() > 1 && words[1] == "--quick";
  const std::string hgros = words[0];
  MeasureStarts(hgros, quick ? 10 : 30);
  MeasureList(hgros, quick ? 10 : 30);
  MeasureEcho(hgros, std::chrono::seconds(quick ? 2 : 10));
  MeasureTop(hgros, std::chrono::seconds(quick ? 3 : 10));
  MeasureObserver(hgros, quick ? 4 : 20);
  MeasureSize(hgros);
  return 0;
}
