#include "hgros/clock/following_clock.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;

// A clock, another one that follows it, and the steady clock of their host, which only the test advances.
class FollowingClockTest : public testing::Test {
 protected:
  FollowingClockTest() {
    listening_ = follower_.OnJump([this](const ClockJump& jump) { jumps_.push_back(jump); });
  }
  void Tell() { follower_.Follow(driver_.State()); }
  void ExpectTheSame() {
    EXPECT_EQ(follower_.Now(), driver_.Now());
    EXPECT_EQ(follower_.State().rate, driver_.rate());
    EXPECT_EQ(follower_.State().paused, driver_.paused());
  }

  const std::shared_ptr<SimulatedClock> steady_ = SimulatedClock::Paused(Time{1'000'000});
  SimulatedClock driver_{Time{} + 100s, steady_};
  FollowingClock follower_{steady_};
  std::vector<ClockJump> jumps_;
  Listening listening_;
};

TEST_F(FollowingClockTest, StandsAtZeroUntilTheFirstStateThenJumps) {
  steady_->Step(1h);
  EXPECT_EQ(follower_.Now(), Time{});
  follower_.FollowAnother(driver_.State());
  ExpectTheSame();
  ASSERT_EQ(jumps_.size(), 1U);
  EXPECT_EQ(jumps_.at(0).before, Time{});
  EXPECT_EQ(jumps_.at(0).after, driver_.Now());
  EXPECT_EQ(follower_.Read().elapsed(), Time{});
}

TEST_F(FollowingClockTest, RunsByItselfBetweenStates) {
  follower_.FollowAnother(driver_.State());
  steady_->Step(7s);
  ExpectTheSame();
  driver_.SetRate(2.5);
  Tell();
  steady_->Step(2s);
  ExpectTheSame();
  EXPECT_EQ(jumps_.size(), 1U);
}

TEST_F(FollowingClockTest, JumpsWithTheOtherClockAndTreatsStepsAsPassedTime) {
  follower_.FollowAnother(driver_.State());
  driver_.Pause();
  Tell();
  driver_.Step(10s);
  Tell();
  ExpectTheSame();
  EXPECT_EQ(jumps_.size(), 1U);
  const Time elapsed = follower_.Read().elapsed();
  driver_.JumpTo(Time{} + 20s);
  driver_.Step(3s);
  Tell();
  ExpectTheSame();
  EXPECT_EQ(jumps_.size(), 2U);
  EXPECT_EQ(follower_.Read().elapsed(), elapsed + 3s) << "the step passed, the jump did not";
  driver_.JumpTo(Time{} + 5000s);
  Tell();
  ExpectTheSame();
  EXPECT_EQ(jumps_.size(), 3U);
}

TEST_F(FollowingClockTest, StandsStillWhenItHasRunAhead) {
  follower_.FollowAnother(driver_.State());
  driver_.Pause();
  steady_->Step(50ms);  // The follower learns of the pause this much later.
  Tell();
  EXPECT_EQ(follower_.Now(), driver_.Now() + 50ms);
  driver_.Resume();
  Tell();
  steady_->Step(30ms);
  EXPECT_EQ(follower_.Now(), driver_.Now() + 20ms);
  steady_->Step(30ms);
  ExpectTheSame();
  EXPECT_EQ(jumps_.size(), 1U);
}

TEST_F(FollowingClockTest, JumpsToTheExactTimeAlsoWhenItHasRunAhead) {
  follower_.FollowAnother(driver_.State());
  driver_.Pause();
  steady_->Step(50ms);
  const Time elapsed = follower_.Read().elapsed();
  driver_.JumpTo(Time{} + 200s);
  Tell();
  ExpectTheSame();
  EXPECT_EQ(follower_.Read().elapsed(), elapsed) << "elapsed time does not go back";
}

TEST_F(FollowingClockTest, WakesSleepersWithoutAState) {
  FollowingClock follower;
  SimulatedClock driver(Time{} + 100s);
  driver.SetRate(1000);
  follower.FollowAnother(driver.State());
  EXPECT_TRUE(SleepUntil(follower, Time{} + 110s));
  EXPECT_GE(follower.Now(), Time{} + 110s);
}

TEST_F(FollowingClockTest, WakesSleepersOnJumpsAndSteps) {
  follower_.FollowAnother(driver_.State());
  for (const bool jump : {true, false}) {
    std::atomic<bool> awake{false};
    const Time due = driver_.Now() + 10s;
    std::jthread sleeper([&] {
      EXPECT_TRUE(SleepUntil(follower_, due));
      awake = true;
    });
    if (jump) {
      driver_.JumpTo(due);
    } else {
      driver_.Step(10s);
    }
    EXPECT_FALSE(awake);
    Tell();
    EXPECT_TRUE(test::Await([&] { return awake.load(); }));
  }
}

// With any delay of the states: between jumps no reading goes back, and elapsed time never goes back.
TEST_F(FollowingClockTest, NeverGoesBackByItself) {
  std::mt19937_64 random(test::Seed());
  follower_.FollowAnother(driver_.State());
  ClockReading last = follower_.Read();
  for (int i = 0; i < 5000; ++i) {
    switch (random() % 8) {
      case 0: driver_.SetRate(0.1 + static_cast<double>(random() % 100)); break;
      case 1: driver_.Pause(); break;
      case 2: driver_.Resume(); break;
      case 3: driver_.Step(Duration(random() % 1'000'000)); break;
      case 4: driver_.JumpTo(Time{static_cast<std::int64_t>(random() % 1'000'000'000)}); break;
      case 5: Tell(); break;
      default: steady_->Step(Duration(random() % 1'000'000));
    }
    const ClockReading now = follower_.Read();
    ASSERT_GE(now.elapsed(), last.elapsed());
    if (now.jumped == last.jumped) {
      ASSERT_GE(now.now, last.now);
    }
    last = now;
  }
  driver_.JumpTo(Time{} + 1000s);
  Tell();
  ExpectTheSame();
}

}  // namespace
}  // namespace hgros
