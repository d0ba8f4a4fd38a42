// The cost of a transform tree: ours beside tf2, in the same rounds.
#include <malloc.h>
#include <time.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "chain.hpp"
#include "hgros/clock/time.hpp"
#include "sides.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

constexpr int kTrees = 8;

std::atomic<double> sink{0};

double NanosecondsOf(const std::function<void()>& work) {
  const std::int64_t start = MonotonicNow();
  work();
  return static_cast<double>(MonotonicNow() - start);
}

struct Times {
  std::vector<std::int64_t> near;
  std::vector<std::int64_t> old;
};

// Times between stamps: within the last 100 ms, and within the last 9 s.
Times MomentsBefore(int last_step) {
  std::mt19937_64 random(7);
  Times times;
  const auto within = [&](int steps) {
    return StampOf(last_step) - std::uniform_int_distribution<std::int64_t>(1, steps * kPeriod - 1)(random);
  };
  for (int i = 0; i < 4096; ++i) times.near.push_back(within(10));
  for (int i = 0; i < 4096; ++i) times.old.push_back(within(900));
  return times;
}

struct Costs {
  Samples latest, unchanged, near, old, set;
};

double AtEach(Side& side, const std::vector<std::int64_t>& moments) {
  double sum = 0;
  const double time = NanosecondsOf([&] {
    for (const std::int64_t moment : moments) sum += side.At(moment);
  });
  sink = sum;
  return time / static_cast<double>(moments.size());
}

// One implementation with several trees, so that a tree has changed between two lookups in it, without reading a clock
// in between.
class Bench {
 public:
  explicit Bench(const std::function<std::unique_ptr<Side>()>& make) {
    for (int i = 0; i < kTrees; ++i) trees_.push_back(make());
    for (; step_ < kSteps; ++step_) SetAll();
  }

  void Round(int count) {
    double latest = 0;
    double sum = 0;
    const int repeats = count / kTrees;
    for (int i = 0; i < repeats; ++i) {
      ++step_;
      SetAll();
      latest += NanosecondsOf([&] {
        for (const auto& tree : trees_) sum += tree->Latest();
      });
    }
    const double clock = NanosecondsOf([] {});
    costs_.latest.Add((latest / repeats - clock) / kTrees);
    Side& tree = *trees_.front();
    costs_.unchanged.Add(NanosecondsOf([&] {
                           for (int i = 0; i < count; ++i) sum += tree.Latest();
                         }) /
                         count);
    const Times times = MomentsBefore(step_);
    costs_.near.Add(AtEach(tree, times.near));
    costs_.old.Add(AtEach(tree, times.old));
    const int sets = 800 * kDepth;
    costs_.set.Add(NanosecondsOf([&] { tree.SetMany(step_ + 1, sets); }) / sets);
    for (std::size_t i = 1; i < trees_.size(); ++i) trees_[i]->SetMany(step_ + 1, sets);
    step_ += sets / kDepth;
    sink = sum;
  }
  [[nodiscard]] const Costs& costs() const { return costs_; }

 private:
  void SetAll() {
    for (const auto& tree : trees_) tree->SetAll(step_);
  }
  std::vector<std::unique_ptr<Side>> trees_;
  int step_ = 0;
  Costs costs_;
};

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

struct Rates {
  double by_wall = 0;  ///< Look-ups of all readers per second.
  double by_cpu = 0;   ///< The sum over the readers of lookups per second of their own CPU time.
};

// Readers that look up within the last 100 ms, if requested beside a writer at full speed. The writer fills the 10 s of
// the buffer within less than a ms. If a reader loses its core in that time, its time is too old, which is correct.
Rates Read(Side& tree, int& last_step, int readers, int count, bool beside_writer) {
  std::vector<std::int64_t> before;  // ns before the newest
  for (const std::int64_t moment : MomentsBefore(last_step).near) before.push_back(StampOf(last_step) - moment);
  std::atomic<bool> stop{false};
  std::atomic<int> written{last_step};
  std::thread writer;
  if (beside_writer) {
    writer = std::thread([&] {
      for (; !stop; last_step += 10) {
        tree.SetMany(last_step + 1, 10 * kDepth);
        written.store(last_step + 10, std::memory_order_relaxed);
      }
    });
  }
  std::vector<double> rates(static_cast<std::size_t>(readers));
  const double wall = NanosecondsOf([&] {
    std::vector<std::jthread> threads;
    for (int r = 0; r < readers; ++r) {
      threads.emplace_back([&, r] {
        double sum = 0;
        const double start = ThreadSeconds();
        for (int i = 0; i < count; ++i) {
          const std::int64_t newest = StampOf(written.load(std::memory_order_relaxed));
          sum += tree.At(newest - before[static_cast<std::size_t>(i) % before.size()]);
        }
        rates[static_cast<std::size_t>(r)] = count / (ThreadSeconds() - start);
        sink = sum;
      });
    }
  });
  stop = true;
  if (writer.joinable()) writer.join();
  Rates result{readers * static_cast<double>(count) / wall * 1e9, 0};
  for (const double rate : rates) result.by_cpu += rate;
  return result;
}

std::size_t HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

double BytesPerTransform(const std::function<std::unique_ptr<Side>()>& make) {
  const std::unique_ptr<Side> tree = make();
  const std::size_t before = HeapBytes();
  // Twice what the buffer keeps. The memory still in use afterwards is what it needs.
  for (int step = 0; step < 2 * kSteps; ++step) tree->SetAll(step);
  return static_cast<double>(HeapBytes() - before) / (kSteps * kDepth);
}

void ReportCosts(const std::string& name, const Costs& costs) {
  Report(name + "_latest_depth8_ns", costs.latest.Median(), "ns");
  Report(name + "_unchanged_depth8_ns", costs.unchanged.Median(), "ns");
  Report(name + "_interpolated_depth8_ns", costs.near.Median(), "ns");
  Report(name + "_old_depth8_ns", costs.old.Median(), "ns");
  Report(name + "_set_ns", costs.set.Median(), "ns");
}

void ReportRatio(const std::string& metric, const Samples& ours, const Samples& theirs) {
  Report(metric, ours.Median() / theirs.Median(), "ratio");
}

void Run(bool quick) {
  const int rounds = quick ? 5 : 21;
  const int count = quick ? 20'000 : 100'000;
  const bool has_tf2 = MakeTf2() != nullptr;

  Bench ours(MakeOurs);
  Bench named(MakeOursNamed);
  const std::unique_ptr<Bench> tf2 = has_tf2 ? std::make_unique<Bench>(MakeTf2) : nullptr;
  for (int round = 0; round < rounds; ++round) {
    ours.Round(count);
    named.Round(count);
    if (tf2) tf2->Round(count / 10);
  }
  ReportCosts("ours", ours.costs());
  ReportCosts("ours_named", named.costs());
  if (tf2) {
    ReportCosts("tf2", tf2->costs());
    const Costs& peer = tf2->costs();
    ReportRatio("lookup_latest_depth8_ratio", ours.costs().latest, peer.latest);
    ReportRatio("lookup_latest_named_depth8_ratio", named.costs().latest, peer.latest);
    ReportRatio("lookup_unchanged_depth8_ratio", ours.costs().unchanged, peer.unchanged);
    ReportRatio("lookup_interpolated_depth8_ratio", ours.costs().near, peer.near);
    ReportRatio("lookup_old_depth8_ratio", ours.costs().old, peer.old);
    ReportRatio("set_ratio", ours.costs().set, peer.set);
    ReportRatio("set_named_ratio", named.costs().set, peer.set);
  }

  const auto scaling = [&](const std::string& name, const std::function<std::unique_ptr<Side>()>& make, int lookups) {
    const std::unique_ptr<Side> tree = make();
    for (int step = 0; step <= kSteps; ++step) tree->SetAll(step);
    Samples alone, beside;
    int last = kSteps;
    for (int round = 0; round < rounds; ++round) {
      alone.Add(Read(*tree, last, 2, lookups, false).by_wall / Read(*tree, last, 1, lookups, false).by_wall);
    }
    Report(name + "_2threads_scaling", alone.Median(), "ratio");
    Samples one_beside;
    for (int round = 0; round < rounds; ++round) {
      const double two = Read(*tree, last, 2, lookups, true).by_cpu;
      const double one = Read(*tree, last, 1, lookups, true).by_cpu;
      one_beside.Add(one);
      beside.Add(two / one);
    }
    Report(name + "_2threads_scaling_beside_writer", beside.Median(), "ratio");
    Report(name + "s_per_s_beside_writer", one_beside.Median(), "1/s");
  };
  scaling("lookup", MakeOurs, count * 2);
  if (has_tf2) scaling("tf2_lookup", MakeTf2, count / 5);

  Samples cloud;
  for (int round = 0; round < rounds; ++round) cloud.Add(CloudPointsPerSecond(120'000, quick ? 5 : 20));
  Report("cloud_transform_points_per_s", cloud.Median(), "1/s");
  Report("memory_per_transform_bytes", BytesPerTransform(MakeOurs), "bytes");
  if (has_tf2) Report("tf2_memory_per_transform_bytes", BytesPerTransform(MakeTf2), "bytes");
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  hgros::bench::Run(argc > 1 && std::strcmp(argv[1], "--quick") == 0);
  return 0;
}
