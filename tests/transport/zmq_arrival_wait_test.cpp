#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "transport/zmq/arrival_wait.hpp"

namespace hgros::zmq {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

TEST(ArrivalWait, EndsAtTheFirstLookIfNothingIsArriving) {
  ArrivalWait wait;
  int looks = 0;
  wait.Await(std::chrono::hours(1), std::chrono::hours(1), [&] {
    ++looks;
    return Arriving{};
  });
  EXPECT_EQ(looks, 1);
}

TEST(ArrivalWait, EndsWhenEverythingHasArrived) {
  ArrivalWait wait;
  std::atomic<bool> looked{false};
  std::atomic<bool> arrived{false};
  const std::jthread reads([&] {
    looked.wait(false);
    arrived = true;
    wait.NoteRound();
  });
  wait.Await(std::chrono::hours(1), std::chrono::hours(1), [&] {
    const Arriving arriving{.any = !arrived, .progress = 1};
    looked = true;
    looked.notify_all();
    return arriving;
  });
  EXPECT_TRUE(arrived);
}

TEST(ArrivalWait, GivesUpWithoutProgress) {
  ArrivalWait wait;
  const auto began = Clock::now();
  wait.Await(milliseconds(30), std::chrono::hours(1), [] { return Arriving{.any = true, .progress = 1}; });
  EXPECT_GE(Clock::now() - began, milliseconds(30));
}

TEST(ArrivalWait, ContinuesWithProgressForALimitedTime) {
  ArrivalWait wait;
  const auto began = Clock::now();
  std::uint64_t progress = 0;
  // On a busy machine a look may come late, but each finds progress.
  wait.Await(milliseconds(50), milliseconds(200), [&] { return Arriving{.any = true, .progress = ++progress}; });
  EXPECT_GE(Clock::now() - began, milliseconds(200));
}

}  // namespace
}  // namespace hgros::zmq
