#include "hgros/clock/clock_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hgros {
namespace {

using namespace std::chrono_literals;

// A remote clock with a drifting offset, behind a network with a different delay in each direction.
class RemoteClock {
 public:
  RemoteClock(unsigned seed, Duration offset, double drift) : random_(seed), offset_(offset), drift_(drift) {}

  [[nodiscard]] Duration OffsetAt(Time local) const {
    const auto elapsed = static_cast<long double>(local.nanoseconds - kBegin.nanoseconds);
    return offset_ + Duration(std::llround(elapsed * static_cast<long double>(drift_)));
  }
  [[nodiscard]] ClockExchange Exchange(Time asked, Duration least_there, Duration least_back, Duration mean_queue) {
    const Time arrives = asked + least_there + Queue(mean_queue);
    const Time leaves = arrives + 20us;
    const Time got = leaves + least_back + Queue(mean_queue);
    return {asked, arrives + OffsetAt(arrives), leaves + OffsetAt(leaves), got};
  }
  void Set(Duration by) { offset_ += by; }
  void SetDrift(Time local, double drift) {
    offset_ = OffsetAt(local) - Duration(std::llround(static_cast<double>((local - kBegin).count()) * drift));
    drift_ = drift;
  }

  static constexpr Time kBegin{1'700'000'000'000'000'000};

 private:
  Duration Queue(Duration mean) {
    return Duration(std::llround(std::exponential_distribution(1.0)(random_) * static_cast<double>(mean.count())));
  }

  std::mt19937 random_;
  Duration offset_;
  double drift_;
};

constexpr Time kBegin = RemoteClock::kBegin;

TEST(ClockOffsetEstimator, IsEmptyAtFirstAndBoundsTheOffsetByTheDelayOfOneExchange) {
  ClockOffsetEstimator estimator;
  EXPECT_FALSE(estimator.At(kBegin));
  const Time remote = kBegin + 5s;
  EXPECT_TRUE(estimator.Add({kBegin, remote + 1ms, remote + 1ms, kBegin + 2ms}));
  const ClockOffset offset = *estimator.At(kBegin + 1ms);
  EXPECT_NEAR(static_cast<double>(offset.offset.count()), 5e9, 5);
  EXPECT_GE(offset.uncertainty, 1ms);
  EXPECT_LT(offset.uncertainty, 1ms + 1us);
  // The uncertainty grows with time, because the clocks may drift.
  EXPECT_GT(estimator.At(kBegin + 10s)->uncertainty, 5ms);
}

TEST(ClockOffsetEstimator, BoundsTheErrorForSkewedAndDriftingClocks) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const Duration offset = std::chrono::milliseconds(static_cast<std::int64_t>(random() % 2'000'000) - 1'000'000);
    const double drift = (static_cast<double>(random() % 801) - 400.0) * 1e-6;
    RemoteClock remote(seed, offset, drift);
    const Duration there = std::chrono::microseconds(50 + random() % 5'000);
    const Duration back = std::chrono::microseconds(50 + random() % 5'000);
    const Duration queue = std::chrono::microseconds(10 + random() % 10'000);
    ClockOffsetEstimator estimator;
    Time now = kBegin;
    for (int i = 0; i < 200; ++i) {
      now = now + 1s;
      ASSERT_TRUE(estimator.Add(remote.Exchange(now, there, back, queue))) << "seed " << seed;
      for (const Duration later : {0ms, 500ms, 20'000ms}) {
        const ClockOffset estimate = *estimator.At(now + later);
        const Duration fault = estimate.offset - remote.OffsetAt(now + later);
        ASSERT_LE(std::abs(fault.count()), estimate.uncertainty.count()) << "seed " << seed << ", exchange " << i;
      }
      const ClockOffset estimate = *estimator.At(now);
      ASSERT_LE(std::abs(estimate.drift - drift), estimate.drift_uncertainty + 1e-12) << "seed " << seed;
    }
    EXPECT_EQ(estimator.resets(), 0U) << "seed " << seed;
    // At most the least delay, some queueing, and the effect of unknown drift in a minute.
    const ClockOffset last = *estimator.At(now);
    EXPECT_LT(last.uncertainty, (there + back) / 2 + queue + 100us) << "seed " << seed;
    EXPECT_LT(last.drift_uncertainty, 400e-6) << "seed " << seed;
  }
}

TEST(ClockOffsetEstimator, UsesTheExchangeWithTheLeastDelay) {
  RemoteClock remote(3, 1s, 0);
  ClockOffsetEstimator estimator;
  Time now = kBegin;
  (void)estimator.Add(remote.Exchange(now, 100us, 100us, 0us));
  for (int i = 0; i < 20; ++i) {
    now = now + 100ms;
    (void)estimator.Add(remote.Exchange(now, 50ms, 1ms, 5ms));
  }
  // The delayed exchanges would be wrong by 25 ms, this one only by the possible drift of 2 s.
  const ClockOffset estimate = *estimator.At(now);
  EXPECT_LT(std::abs((estimate.offset - 1s).count()), 1'500'000);
  EXPECT_LT(estimate.uncertainty, 1500us);
}

TEST(ClockOffsetEstimator, FollowsAClockThatIsSet) {
  RemoteClock remote(5, 0s, 20e-6);
  ClockOffsetEstimator estimator;
  Time now = kBegin;
  const auto run = [&](int exchanges) {
    for (int i = 0; i < exchanges; ++i) {
      now = now + 1s;
      ASSERT_TRUE(estimator.Add(remote.Exchange(now, 1ms, 1ms, 100us)));
    }
  };
  run(50);
  remote.Set(-1h);
  run(1);
  EXPECT_GT(estimator.At(now)->offset, -1s);  // A single exchange is not believed.
  run(4);
  EXPECT_EQ(estimator.resets(), 1U);
  const ClockOffset estimate = *estimator.At(now);
  EXPECT_LE(std::abs((estimate.offset - remote.OffsetAt(now)).count()), estimate.uncertainty.count());
}

TEST(ClockOffsetEstimator, RecoversFromAChangedDrift) {
  RemoteClock remote(7, 0s, 100e-6);
  ClockOffsetEstimator estimator;
  Time now = kBegin;
  for (int i = 0; i < 400; ++i) {
    if (i == 100) remote.SetDrift(now, -100e-6);
    now = now + 1s;
    ASSERT_TRUE(estimator.Add(remote.Exchange(now, 1ms, 1ms, 100us)));
  }
  const ClockOffset estimate = *estimator.At(now);
  EXPECT_LE(std::abs((estimate.offset - remote.OffsetAt(now)).count()), estimate.uncertainty.count());
  EXPECT_NEAR(estimate.drift, -100e-6, estimate.drift_uncertainty);
}

TEST(ClockOffsetEstimator, RefusesImpossibleExchanges) {
  ClockOffsetEstimator estimator;
  const Time t = kBegin;
  EXPECT_FALSE(estimator.Add({t, t, t, t - 1ms}));        // the answer came before the question
  EXPECT_FALSE(estimator.Add({t, t + 1ms, t, t + 2ms}));  // the remote clock went back
  EXPECT_FALSE(estimator.Add({t, t, t + 3s, t + 1s}));    // the remote part took longer than the whole
  EXPECT_FALSE(estimator.Add({t, Time{-9'000'000'000'000'000'000}, t, t}));  // the difference overflows
  EXPECT_FALSE(estimator.At(t));
}

TEST(ClockOffsetEstimator, SurvivesAnyInput) {
  std::mt19937_64 random(9);
  ClockOffsetEstimator estimator;
  for (int i = 0; i < 2'000; ++i) {
    const auto any = [&] { return Time{static_cast<std::int64_t>(random() >> (random() % 64))}; };
    (void)estimator.Add({any(), any(), any(), any()});
    (void)estimator.At(any());
  }
}

}  // namespace
}  // namespace hgros
