// The side in C++ of the benchmark of Python.
//   bench_python_cpp talk ROUNDS FLOOD   publishes each round one small and one large message to C++ and to Python,
//                                        then FLOOD small messages as fast as the subscriber takes them
//   bench_python_cpp listen ROUNDS       receives its part, and prints the median latencies in ns: small, large since
//                                        publishing, large since writing began
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/PointCloud.pb.h>

#include "hgros/hgros.hpp"

namespace {

using namespace std::chrono_literals;
using Cloud = hgros::Bulk<foxglove::PointCloud>;
constexpr std::size_t kLargeBytes = 4 << 20;
constexpr auto kPause = 3ms;  // Receivers sleep between two messages, as those of a robot do.

foxglove::LaserScan SmallScan() {
  foxglove::LaserScan scan;
  scan.set_frame_id("laser");
  for (int i = 0; i < 124; ++i) scan.add_ranges(i);  // With the rest 1 KB.
  return scan;
}

// The moment of publishing, in the message itself.
void Stamp(google::protobuf::Timestamp& stamp) {
  const std::int64_t now = hgros::MonotonicNow();
  stamp.set_seconds(now / 1'000'000'000);
  stamp.set_nanos(static_cast<std::int32_t>(now % 1'000'000'000));
}

std::int64_t Since(const google::protobuf::Timestamp& stamp, std::int64_t now) {
  return now - stamp.seconds() * 1'000'000'000 - stamp.nanos();
}

bool Ready(hgros::Session& session, std::string_view channel) {
  if (session.WaitForSubscribers(channel, 1, 20s)) return true;
  std::fprintf(stderr, "Nobody subscribes to %s.\n", std::string(channel).c_str());
  return false;
}

int Talk(int rounds, int flood) {
  hgros::Session session;
  auto scan = SmallScan();
  const auto small_cpp = session.Advertise<foxglove::LaserScan>("small_cpp");
  const auto small_py = session.Advertise<foxglove::LaserScan>("small_py");
  const auto large_cpp = session.Advertise<Cloud>("large_cpp");
  const auto large_py = session.Advertise<Cloud>("large_py");
  const auto flooded = session.Advertise<foxglove::LaserScan>("flood");
  for (const auto* channel : {"small_cpp", "small_py", "large_cpp", "large_py", "flood"}) {
    if (!Ready(session, channel)) return 1;
  }
  const auto large = [&](const hgros::Publisher<Cloud>& publish, std::string_view channel) {
    auto cloud = session.Loan<Cloud>(channel, kLargeBytes);
    std::this_thread::sleep_for(kPause);
    cloud->head().set_frame_id(std::to_string(hgros::MonotonicNow()));  // When writing began.
    std::memset(cloud->writable().data(), 1, kLargeBytes);
    cloud->writable().back() = std::byte{2};
    Stamp(*cloud->head().mutable_timestamp());
    publish(std::move(cloud));
  };
  for (int i = 0; i < rounds; ++i) {
    std::this_thread::sleep_for(kPause);
    Stamp(*scan.mutable_timestamp());
    small_cpp(scan);
    std::this_thread::sleep_for(kPause);
    Stamp(*scan.mutable_timestamp());
    small_py(scan);
    large(large_cpp, "large_cpp");
    large(large_py, "large_py");
  }
  for (int i = 0; i < flood; ++i) {
    if (flooded.Wait(std::make_unique<foxglove::LaserScan>(scan), std::chrono::steady_clock::now() + 20s) !=
        hgros::PublishStatus::kOk) {
      std::fputs("The subscriber takes no messages.\n", stderr);
      return 1;
    }
  }
  return 0;
}

std::int64_t Median(std::vector<std::int64_t> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

int Listen(int rounds) {
  const auto count = static_cast<std::size_t>(rounds);
  std::vector<std::int64_t> small;
  std::vector<std::int64_t> large;
  std::vector<std::int64_t> written;
  std::atomic<std::size_t> left{2};
  std::atomic<unsigned> sum{0};
  hgros::Session session;
  const auto note = [&](std::vector<std::int64_t>& latencies, std::int64_t latency) {
    latencies.push_back(latency);
    if (latencies.size() == count && left.fetch_sub(1) == 1) left.notify_all();
  };
  const auto first = session.FromAny<foxglove::LaserScan>(
      "small_cpp", hgros::Invoke::kSerial,
      [&](const foxglove::LaserScan& scan) { note(small, Since(scan.timestamp(), hgros::MonotonicNow())); });
  const auto second = session.FromAny<Cloud>("large_cpp", hgros::Invoke::kSerial, [&](const Cloud& cloud) {
    sum += static_cast<unsigned>(cloud.bytes().front()) + static_cast<unsigned>(cloud.bytes().back());
    const std::int64_t now = hgros::MonotonicNow();
    written.push_back(now - std::atoll(cloud.head().frame_id().c_str()));
    note(large, Since(cloud.head().timestamp(), now));
  });
  for (auto now = left.load(); now > 0; now = left.load()) left.wait(now);
  std::printf("%lld %lld %lld\n", static_cast<long long>(Median(small)), static_cast<long long>(Median(large)),
              static_cast<long long>(Median(written)));
  return sum == 3 * count ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view mode = argc > 1 ? argv[1] : "";
  if (mode == "talk" && argc == 4) return Talk(std::atoi(argv[2]), std::atoi(argv[3]));
  if (mode == "listen" && argc == 3) return Listen(std::atoi(argv[2]));
  std::fputs("usage: bench_python_cpp talk ROUNDS FLOOD | listen ROUNDS\n", stderr);
  return 2;
}
