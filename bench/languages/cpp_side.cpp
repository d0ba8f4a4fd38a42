// The publisher of the benchmark of languages, and the receiver in C++.
//   bench_languages_cpp talk FLOOD     publishes FLOOD messages of 1 KB as fast as the subscriber takes them
//   bench_languages_cpp listen FLOOD   receives them in a callback, and prints how many came per second
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <string_view>

#include <foxglove/LaserScan.pb.h>

#include "hgros/hgros.hpp"

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

int Talk(int flood) {
  hgros::Session session;
  const auto publish = session.Advertise<foxglove::LaserScan>("flood");
  if (!session.WaitForSubscribers("flood", 1, 20s)) {
    std::fputs("Nobody subscribes.\n", stderr);
    return 1;
  }
  foxglove::LaserScan scan;
  scan.set_frame_id("laser");
  for (int i = 0; i < 124; ++i) scan.add_ranges(i);  // With the rest 1 KB.
  for (int i = 0; i < flood; ++i) {
    scan.set_start_angle(i);  // The receiver sees if one is missing.
    if (publish.Wait(std::make_unique<foxglove::LaserScan>(scan), Clock::now() + 20s) != hgros::PublishStatus::kOk) {
      std::fputs("The subscriber takes no messages.\n", stderr);
      return 1;
    }
  }
  return 0;
}

int Listen(int flood) {
  hgros::Session session;
  int received = 0;
  Clock::time_point begin;
  std::promise<double> rate;
  const auto subscription = session.FromAny<foxglove::LaserScan>(
      "flood", hgros::Invoke::kSerial,
      [&](const foxglove::LaserScan& scan) {
        if (scan.start_angle() != received) std::abort();
        if (received == 0) begin = Clock::now();
        if (++received == flood) rate.set_value(flood / std::chrono::duration<double>(Clock::now() - begin).count());
      },
      {.queue = hgros::Queue::KeepAll(1000)});
  std::printf("%.0f\n", rate.get_future().get());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view mode = argc == 3 ? argv[1] : "";
  if (mode == "talk") return Talk(std::atoi(argv[2]));
  if (mode == "listen") return Listen(std::atoi(argv[2]));
  std::fputs("usage: bench_languages_cpp talk|listen FLOOD\n", stderr);
  return 2;
}
