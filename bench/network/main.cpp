// What a message between two hosts costs, beside raw TCP moving the same bytes in the same run. Started by ./run in
// one network namespace; starts the receivers in another.
#include <cstdio>
#include <cstring>
#include <string>

#include "support/receiver_process.hpp"

namespace hgros::bench {
namespace {

constexpr double kBitsPerSecond = 1e9;

struct Side {
  Side(const std::string& carrier, const std::string& address, int port, const std::vector<std::string>& prefix)
      : task{carrier, (carrier == "tcp" ? "" : "tcp://") + address + ":" + std::to_string(port), "inline", false},
        receiver(task, prefix),
        sender(MakeSender(task, task.endpoint)) {
    AwaitConnection(receiver.control(), *sender);
  }
  ReceiverTask task;
  ReceiverProcess receiver;
  std::unique_ptr<PairSender> sender;
};

void Run(const std::string& address, const std::vector<std::string>& prefix, bool quick) {
  const int rounds = quick ? 9 : 25;
  Side raw("tcp", address, 24591, prefix);
  Side ours("ours", address, 24592, prefix);
  for (const std::size_t size : kSizes) {
    BlockPool pool(size, 12);
    const double line_ms = static_cast<double>(size) * 8 / kBitsPerSecond * 1e3;
    const int pause_us = 2000 + static_cast<int>(line_ms * 1500);
    const int each = quick ? (size > 1024 * 1024 ? 4 : 10) : 40;
    Samples ratio, floor, mine;
    for (int round = 0; round < rounds; ++round) {
      const Samples raw_now = MeasurePair(raw.receiver.control(), *raw.sender, pool, each, pause_us);
      const Samples ours_now = MeasurePair(ours.receiver.control(), *ours.sender, pool, each, pause_us);
      ratio.Add(ours_now.Median() / raw_now.Median());
      floor.Add(raw_now);
      mine.Add(ours_now);
    }
    const std::string name = SizeName(size);
    ReportLatency("raw_tcp_" + name, floor);
    ReportLatency("ours_" + name, mine);
    Report("line_time_" + name + "_us", line_ms * 1e3, "us");
    Report("latency_ratio_" + name, ratio.Median(), "ratio");
    Report("latency_mean_ratio_" + name, mine.Mean() / floor.Mean(), "ratio");
    if (name == "4MB") Report("latency_4MB_ms", mine.Median() / 1e6, "ms");
  }
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  using namespace hgros::bench;
  if (const int code = ReceiverMain(argc, argv); code >= 0) return code;
  if (argc < 4) {
    std::fprintf(stderr, "usage: bench_network OWN_ADDRESS quick|full COMMAND... (before the receiver's own)\n");
    return 2;
  }
  Run(argv[1], std::vector<std::string>(argv + 3, argv + argc), std::strcmp(argv[2], "quick") == 0);
  return 0;
}
