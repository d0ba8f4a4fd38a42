// The cost of a robot file: starts, the starter, a restart, and a message through a component.
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <foxglove/KeyValuePair.pb.h>

#include "cli/child.hpp"
#include "hgros/component/components.hpp"
#include "hgros/hgros.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

using foxglove::KeyValuePair;

constexpr int kComponents = 10;
constexpr int kProcesses = 5;

// Ten links of a ring; with `processes`, two in each of five.
std::string RobotText(bool processes) {
  std::string text = "components:\n";
  for (int i = 0; i < kComponents; ++i) {
    const std::string number = std::to_string(i);
    text += "  link" + number + ": {type: bench/Link, remap: {last: c" + number + ", next: c" +
            std::to_string((i + 1) % kComponents) + "}}\n";
  }
  if (!processes) return text;
  text += "processes:\n";
  for (int i = 0; i < kProcesses; ++i) {
    text += "  p" + std::to_string(i) + ": {components: [link" + std::to_string(2 * i) + ", link" +
            std::to_string(2 * i + 1) + "], restart: on-failure}\n";
  }
  return text;
}

// Reads until the output has `text` this often more. Returns everything.
std::string ReadUntil(Child& child, const std::string& text, int times) {
  std::string all;
  for (std::size_t from = 0; times > 0;) {
    const std::size_t found = all.find(text, from);
    if (found != std::string::npos) {
      from = found + text.size();
      --times;
      continue;
    }
    const std::string more = child.Read();
    if (more.empty()) throw Error("hgros run ended: " + all);
    all += more;
  }
  return all;
}

double Milliseconds(std::int64_t since) { return static_cast<double>(MonotonicNow() - since) / 1e6; }

struct Robot {
  Robot(const std::string& hgros, const std::filesystem::path& file, int processes)
      : begin(MonotonicNow()), starter({hgros, "run", file.string(), "--json"}) {
    started = ReadUntil(starter, "\"event\":\"started\"", processes);
    ms = Milliseconds(begin);
  }
  std::int64_t begin;
  Child starter;
  std::string started;
  double ms = 0;
};

double MemoryMb(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

pid_t ParentOf(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("PPid:")) return static_cast<pid_t>(std::stol(line.substr(5)));
  }
  return 0;
}

std::vector<pid_t> PidsOf(const std::string& started) {
  const std::string key = "\"pid\":";
  std::vector<pid_t> pids;
  for (std::size_t at = started.find(key); at != std::string::npos; at = started.find(key, at + 1)) {
    pids.push_back(static_cast<pid_t>(std::stol(started.substr(at + key.size()))));
  }
  return pids;
}

void MeasureStarts(const std::string& hgros, const std::filesystem::path& folder, int count) {
  for (const bool several : {true, false}) {
    const std::filesystem::path file = folder / (several ? "five.yaml" : "one.yaml");
    std::ofstream(file) << RobotText(several);
    Samples times;
    Samples floor;
    for (int i = 0; i < count; ++i) {
      times.Add(Robot(hgros, file, several ? kProcesses : 1).ms);
      floor.Add(RunTime({"/bin/true"}));
    }
    const std::string name = several ? "start" : "one_process_start";
    Report(name + "_ms", times.Median(), "ms");
    Report(name + "_p90_ms", times.Quantile(0.9), "ms");
    Report(name + "_exec_true_ms", floor.Median(), "ms");
  }
}

void MeasureStarter(const std::string& hgros, const std::filesystem::path& folder, std::chrono::seconds time) {
  Robot robot(hgros, folder / "five.yaml", kProcesses);
  const std::vector<pid_t> pids = PidsOf(robot.started);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const std::int64_t cpu = robot.starter.CpuTime();
  const std::int64_t begin = MonotonicNow();
  std::this_thread::sleep_for(time);
  Report("starter_cpu_percent",
         100 * static_cast<double>(robot.starter.CpuTime() - cpu) / static_cast<double>(MonotonicNow() - begin), "%");
  Report("starter_rss_mb", MemoryMb(ParentOf(pids.at(0))), "MB");
  Samples restarts;  // Each process once: further restarts wait on purpose.
  for (const pid_t pid : pids) {
    const std::int64_t killed = MonotonicNow();
    (void)kill(pid, SIGKILL);
    const std::string rest = ReadUntil(robot.starter, "started again", 1);
    const std::size_t after = rest.find("started again");
    const bool one = rest.find("\"text\":\"runs\"", after) != std::string::npos;
    (void)ReadUntil(robot.starter, "\"text\":\"runs\"", one ? 1 : 2);
    restarts.Add(Milliseconds(killed));
  }
  Report("restart_ms", restarts.Median(), "ms");
}

// ns for a message from one publisher to an inline callback.
double PerMessage(Session& session, const std::string& channel, std::uint64_t& heard) {
  constexpr int kMessages = 20'000;
  const auto publish = session.Advertise<KeyValuePair>(channel);
  const auto message = std::make_shared<const KeyValuePair>();
  const std::uint64_t before = heard;
  const std::int64_t begin = MonotonicNow();
  for (int i = 0; i < kMessages; ++i) (void)publish(message);
  const double ns = static_cast<double>(MonotonicNow() - begin) / kMessages;
  if (heard - before != kMessages) throw Error("A message was lost.");
  return ns;
}

std::uint64_t heard_by_component = 0;

class Hears {
 public:
  explicit Hears(Context& context) {
    context.FromAny<KeyValuePair>("through", Invoke::kSerial, [](const KeyValuePair&) { ++heard_by_component; },
                                  {.name = {}, .queue = {}, .executor = Executor::Inline()});
  }
};

void MeasureComponent(int count) {
  Session session(Config::Parse("discovery: {domain: none, local: false}"), SessionOptions{"bench"});
  std::uint64_t heard = 0;
  const Subscription subscription =
      session.FromAny<KeyValuePair>("bare", Invoke::kSerial, [&heard](const KeyValuePair&) { ++heard; },
                                    {.name = {}, .queue = {}, .executor = Executor::Inline()});
  Components components(session);
  (void)components.Add(ComponentTypeOf<Hears>("bench/Hears"), {.name = "hears", .type = "bench/Hears"});
  components.Join();
  components.Start();
  Samples floor;
  Samples through;
  Samples ratios;
  // Both in each round, one right after the other, each first in turn: what disturbs a round disturbs both.
  for (int i = 0; i < count; ++i) {
    const double before = i % 2 == 0 ? PerMessage(session, "bare", heard) : 0;
    const double component = PerMessage(session, "through", heard_by_component);
    const double bare = i % 2 == 0 ? before : PerMessage(session, "bare", heard);
    floor.Add(bare);
    through.Add(component);
    ratios.Add(component / bare);
  }
  Report("bare_subscription_ns", floor.Median(), "ns");
  Report("component_ns", through.Median(), "ns");
  Report("component_overhead_ratio", ratios.Median(), "1");
}

int Main(const std::vector<std::string>& words) {
  const std::string& hgros = words.at(1);
  const bool quick = words.size() > 3;
  setenv("HGROS_COMPONENT_PATH", words.at(2).c_str(), 1);
  setenv("HGROS_DOMAIN", ("bench-placement-" + std::to_string(getpid())).c_str(), 1);
  std::string name = (std::filesystem::temp_directory_path() / "hgros_bench_XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(name.data());
  MeasureStarts(hgros, folder, quick ? 7 : 30);
  MeasureStarter(hgros, folder, std::chrono::seconds(quick ? 5 : 20));
  MeasureComponent(quick ? 100 : 1000);
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) { return hgros::bench::Main(std::vector<std::string>(argv, argv + argc)); }
