// The cost of passing messages inside a process, beside the cost of the parts below by themselves.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <thread>
#include <vector>

#include "floor.hpp"
#include "ours.hpp"

namespace hgros::bench {
namespace {

// Keeps every CPU busy from another process while it lives.
class Burners {
 public:
  Burners() {
    for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
      const pid_t child = fork();
      if (child == 0) {
        alarm(60);  // Ends by itself even if the parent is killed.
        for (std::atomic<unsigned> spin{0};;) spin.fetch_add(1, std::memory_order_relaxed);
      }
      if (child > 0) children_.push_back(child);
    }
  }
  ~Burners() {
    for (const pid_t child : children_) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
  }

 private:
  std::vector<pid_t> children_;
};

void Run(bool quick) {
  const int rounds = quick ? 9 : 25;
  const int latencies = quick ? 100 : 400;
  const int inline_count = quick ? 200'000 : 1'000'000;
  const int flood = quick ? 100'000 : 400'000;

  Samples handle, handle_large, named, fanout, fanout_tbb, scaling, machine, throughput_ratio;
  Samples floor_tbb, ours_tbb, floor_thread, ours_dedicated, pipeline, pipeline_inline;
  Samples tbb_ratio, dedicated_ratio, ours_throughput, floor_throughput, size_ratio;
  for (int round = 0; round < rounds; ++round) {
    const double small = InlineHandle(1024, inline_count);
    const double large = InlineHandle(4096 * 1024, inline_count);
    handle.Add(small);
    handle_large.Add(large);
    size_ratio.Add(large / small);
    named.Add(InlineNamed(inline_count));
    fanout.Add(Fanout20Inline(inline_count / 20));
    fanout_tbb.Add(Fanout20Tbb(flood / 20));
    const double one = NamedThroughput(1, inline_count);
    scaling.Add(NamedThroughput(2, inline_count) / one);
    machine.Add(FloorTwoThreads());

    const Samples floor = FloorTbbLatency(latencies);
    const Samples ours = Latency(Executor::Tbb(), latencies);
    tbb_ratio.Add(ours.Median() / floor.Median());
    floor_tbb.Add(floor);
    ours_tbb.Add(ours);
    const Samples thread = FloorThreadLatency(latencies);
    const Samples dedicated = Latency(Executor::Dedicated(), latencies);
    dedicated_ratio.Add(dedicated.Median() / thread.Median());
    floor_thread.Add(thread);
    ours_dedicated.Add(dedicated);

    const double floor_rate = FloorTbbThroughput(flood);
    const double ours_rate = TbbThroughput(flood);
    floor_throughput.Add(floor_rate);
    ours_throughput.Add(ours_rate);
    throughput_ratio.Add(ours_rate / floor_rate);
    pipeline.Add(Pipeline10(Executor::Tbb(), latencies));
    pipeline_inline.Add(Pipeline10(Executor::Inline(), latencies));
  }
  Samples tbb_busy, dedicated_busy, floor_busy, floor_tbb_busy;
  {
    const Burners burners;
    const int busy = quick ? 300 : 2000;
    tbb_busy = Latency(Executor::Tbb(), busy);
    dedicated_busy = Latency(Executor::Dedicated(), busy);
    floor_busy = FloorThreadLatency(busy);
    floor_tbb_busy = FloorTbbLatency(busy);
  }

  Report("inline_handle_ns", handle.Median(), "ns");
  Report("inline_handle_mean_ns", handle.Mean(), "ns");
  Report("inline_handle_4MB_ns", handle_large.Median(), "ns");
  Report("inline_size_ratio", size_ratio.Median(), "ratio");
  Report("inline_named_ns", named.Median(), "ns");
  Report("inline_named_mean_ns", named.Mean(), "ns");
  Report("fanout20_ns_per_subscriber", fanout.Median(), "ns");
  Report("fanout20_tbb_ns_per_subscriber", fanout_tbb.Median(), "ns");
  Report("named_2threads_scaling", scaling.Median(), "ratio");
  Report("machine_2threads_scaling", machine.Median(), "ratio");
  ReportLatency("tbb_handoff", floor_tbb);
  ReportLatency("tbb_serial", ours_tbb);
  Report("tbb_serial_latency_ratio", tbb_ratio.Median(), "ratio");
  ReportLatency("thread_handoff", floor_thread);
  ReportLatency("dedicated", ours_dedicated);
  Report("dedicated_latency_ratio", dedicated_ratio.Median(), "ratio");
  Report("tbb_floor_throughput_per_s", floor_throughput.Median(), "1/s");
  Report("tbb_serial_throughput_per_s", ours_throughput.Median(), "1/s");
  Report("tbb_serial_throughput_ratio", throughput_ratio.Median(), "ratio");
  ReportLatency("pipeline10", pipeline);
  Report("pipeline10_over_tbb_handoff", pipeline.Median() / floor_tbb.Median(), "ratio");
  ReportLatency("pipeline10_inline", pipeline_inline);
  ReportLatency("tbb_busy", tbb_busy);
  ReportLatency("dedicated_busy", dedicated_busy);
  ReportLatency("tbb_handoff_busy", floor_tbb_busy);
  ReportLatency("thread_handoff_busy", floor_busy);
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  hgros::bench::Run(argc > 1 && std::strcmp(argv[1], "--quick") == 0);
  return 0;
}
