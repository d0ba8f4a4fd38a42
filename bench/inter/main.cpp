// The cost of a message between two processes, beside raw ZeroMQ moving the same bytes in the same run.
#include <unistd.h>

#include <cstring>
#include <string>
#include <vector>

#include <foxglove/PointCloud.pb.h>

#include "support/receiver_process.hpp"

namespace hgros::bench {
namespace {

struct Side {
  Side(const ReceiverTask& task, const std::string& bind_to) : receiver(task), sender(MakeSender(task, bind_to)) {
    AwaitConnection(receiver.control(), *sender);
  }
  ReceiverProcess receiver;
  std::unique_ptr<PairSender> sender;
};

std::string Endpoint(const std::string& scheme, const std::string& who) {
  static int port = 24600 + static_cast<int>(getpid() % 1000) * 8;
  if (scheme == "shm") return who == "shm" ? MemoryFile() : "domain:bench-" + std::to_string(getpid()) + who;
  if (scheme == "tcp") return "tcp://127.0.0.1:" + std::to_string(port++);
  return "ipc://@hgros_bench_" + std::to_string(getpid()) + "_" + who;  // An abstract name leaves no file.
}

Side MakeSide(const std::string& scheme, const std::string& transport, const std::string& executor, bool lossless) {
  const std::string who =
      scheme == "shm" && transport == "shm" ? transport : transport + executor + (lossless ? "_lossless" : "");
  const std::string endpoint = Endpoint(scheme, who);
  return Side({transport, endpoint, executor, lossless}, endpoint);
}

// The cost of copying that many bytes once, from one of a dozen buffers to another.
Samples CopyTimes(std::size_t size, int count) {
  std::vector<std::vector<char>> from(12, std::vector<char>(size, 'x')), to(12, std::vector<char>(size, 'y'));
  Samples samples;
  for (int i = 0; i < count; ++i) {
    const auto slot = static_cast<std::size_t>(i % 12);
    const std::int64_t start = MonotonicNow();
    std::memcpy(to[slot].data(), from[slot].data(), size);
    samples.Add(static_cast<double>(MonotonicNow() - start));
    asm volatile("" : : "r"(to[slot].data()) : "memory");
  }
  return samples;
}

// A protobuf message through shared memory: serialized into it, parsed from it.
void Plain(int rounds, int each) {
  Side plain = MakeSide("shm", "plain", "inline", false);
  for (const std::size_t size : kSizes) {
    BlockPool pool(size, size >= 1024 * 1024 ? 12 : 64);
    const int pause_us = size >= 1024 * 1024 ? 8000 : 2000;
    Samples ratio, mine;
    // Creates the messages.
    MeasurePair(plain.receiver.control(), *plain.sender, pool, size >= 1024 * 1024 ? 12 : 64, pause_us);
    for (int round = 0; round < rounds; ++round) {
      const Samples now = MeasurePair(plain.receiver.control(), *plain.sender, pool, each, pause_us);
      ratio.Add(now.Median() / CopyTimes(size, each).Median());
      mine.Add(now);
    }
    ReportLatency("shm_plain_" + SizeName(size), mine);
    Report("shm_plain_" + SizeName(size) + "_over_memcpy", ratio.Median(), "ratio");
  }
}

// A lent point cloud through shared memory. Its time does not depend on its size, except for the first access to the
// memory. All sizes have the same pause between messages and take turns, because the caches of a machine empty while it
// rests.
void Lent(int rounds, int each) {
  Side bulk = MakeSide("shm", "bulk", "inline", false);
  constexpr int kPauseUs = 2000;
  std::vector<BlockPool> pools;
  for (const std::size_t size : kSizes) {
    pools.emplace_back(size, 12);
    MeasurePair(bulk.receiver.control(), *bulk.sender, pools.back(), 12, kPauseUs);  // Creates the memory.
  }
  std::vector<Samples> mine(pools.size());
  Samples ratio;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> medians;
    for (std::size_t i = 0; i < pools.size(); ++i) {
      const Samples now = MeasurePair(bulk.receiver.control(), *bulk.sender, pools[i], each, kPauseUs);
      medians.push_back(now.Median());
      mine[i].Add(now);
    }
    ratio.Add(medians.back() / medians.front());
  }
  for (std::size_t i = 0; i < pools.size(); ++i) {
    ReportLatency("shm_bulk_" + SizeName(kSizes[i]), mine[i]);
    Report("shm_bulk_p50_us_" + SizeName(kSizes[i]), mine[i].Median() / 1e3, "us");
  }
  Report("shm_bulk_size_ratio", ratio.Median(), "ratio");
}

void Latency(const std::string& scheme, int rounds, int each) {
  Side raw = MakeSide(scheme, scheme == "shm" ? "shm" : "zmq", "inline", false);
  Side ours = MakeSide(scheme, "ours", "inline", false);
  Side tbb = MakeSide(scheme, "ours", "tbb", false);
  for (const std::size_t size : kSizes) {
    BlockPool pool(size, size >= 1024 * 1024 ? 12 : 64);
    const int pause_us = size >= 1024 * 1024 ? 8000 : 2000;
    Samples ratio, floor, mine, worker;
    for (int round = 0; round < rounds; ++round) {
      const Samples raw_now = MeasurePair(raw.receiver.control(), *raw.sender, pool, each, pause_us);
      const Samples ours_now = MeasurePair(ours.receiver.control(), *ours.sender, pool, each, pause_us);
      const Samples tbb_now = MeasurePair(tbb.receiver.control(), *tbb.sender, pool, each / 2, pause_us);
      ratio.Add(ours_now.Median() / raw_now.Median());
      floor.Add(raw_now);
      mine.Add(ours_now);
      worker.Add(tbb_now);
    }
    const std::string name = SizeName(size);
    ReportLatency(scheme + "_raw_" + name, floor);
    ReportLatency(scheme + "_ours_" + name, mine);
    ReportLatency(scheme + "_ours_tbb_" + name, worker);
    Report(scheme + "_latency_ratio_" + name, ratio.Median(), "ratio");
    if (scheme == "shm") {
      Report("shm_p50_us_" + name, mine.Median() / 1e3, "us");
      Report("shm_over_floor_" + name, ratio.Median(), "ratio");
    }
    Report(scheme + "_latency_mean_ratio_" + name, mine.Mean() / floor.Mean(), "ratio");
  }
}

void Throughput(int rounds, int count) {
  Side raw = MakeSide("ipc", "zmq", "inline", false);
  Side ours = MakeSide("ipc", "ours", "inline", true);
  Samples ratio, floor, mine;
  BlockPool pool(1024, 4096);
  for (int round = 0; round < rounds; ++round) {
    const double raw_rate = FloodPair(raw.receiver.control(), *raw.sender, pool, count);
    const double our_rate = FloodPair(ours.receiver.control(), *ours.sender, pool, count);
    floor.Add(raw_rate);
    mine.Add(our_rate);
    ratio.Add(our_rate / raw_rate);
  }
  Report("ipc_raw_throughput_1KB_per_s", floor.Median(), "1/s");
  Report("ipc_throughput_1KB_per_s", mine.Median(), "1/s");
  Report("ipc_throughput_ratio_1KB", ratio.Median(), "ratio");
}

void Protobuf() {
  for (const std::size_t size : kSizes) {
    foxglove::PointCloud cloud;
    cloud.set_frame_id("lidar");
    cloud.set_point_stride(16);
    cloud.set_data(std::string(size, 'x'));
    std::string wire;
    Samples serialize, parse;
    for (int i = 0; i < 50; ++i) {
      const std::int64_t start = MonotonicNow();
      cloud.SerializeToString(&wire);
      const std::int64_t middle = MonotonicNow();
      foxglove::PointCloud back;
      back.ParseFromString(wire);
      serialize.Add(static_cast<double>(middle - start));
      parse.Add(static_cast<double>(MonotonicNow() - middle));
    }
    Report("protobuf_serialize_" + SizeName(size) + "_us", serialize.Median() / 1e3, "us");
    Report("protobuf_parse_" + SizeName(size) + "_us", parse.Median() / 1e3, "us");
  }
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  using namespace hgros::bench;
  if (const int code = ReceiverMain(argc, argv); code >= 0) return code;
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  for (const char* scheme : {"shm", "ipc", "tcp"}) Latency(scheme, quick ? 9 : 25, quick ? 11 : 100);
  Plain(quick ? 9 : 25, quick ? 11 : 100);
  Lent(quick ? 3 : 25, quick ? 11 : 100);
  Throughput(quick ? 3 : 9, quick ? 50'000 : 200'000);
  Protobuf();
  return 0;
}
