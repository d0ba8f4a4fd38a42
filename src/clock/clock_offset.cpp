#include "hgros/clock/clock_offset.hpp"

#include <algorithm>
#include <cmath>

namespace hgros {
namespace {

constexpr std::size_t kContradictions = 3;

// Offsets may be as large as the time itself: long doubles keep the nanoseconds of their differences.
using Real = long double;

Real Nanoseconds(Duration d) { return static_cast<Real>(d.count()); }
Real Difference(Duration a, Duration b) { return Nanoseconds(a) - Nanoseconds(b); }
Real Difference(Time a, Time b) { return static_cast<Real>(a.nanoseconds) - static_cast<Real>(b.nanoseconds); }

// Empty if the difference overflows: times from the network may be anything.
std::optional<Duration> Between(Time from, Time to) {
  std::int64_t difference = 0;
  if (__builtin_sub_overflow(to.nanoseconds, from.nanoseconds, &difference)) return std::nullopt;
  return Duration(difference);
}

Duration Rounded(Real nanoseconds) {
  constexpr Real kMost = 9.2e18L;
  return Duration(static_cast<std::int64_t>(std::clamp(nanoseconds, -kMost, kMost)));
}

}  // namespace

bool ClockOffsetEstimator::Add(const ClockExchange& exchange) {
  const std::optional<Duration> round_trip = Between(exchange.asked, exchange.got);
  const std::optional<Duration> there = Between(exchange.received, exchange.answered);
  const std::optional<Duration> most = Between(exchange.asked, exchange.received);
  const std::optional<Duration> least = Between(exchange.got, exchange.answered);
  if (!round_trip || !there || !most || !least || round_trip->count() < 0 || there->count() < 0) return false;
  // The remote clock is read at two moments within the exchange, between which it drifts; 1 ns for the halves.
  const Real drifted = Nanoseconds(*round_trip) / 2 * options_.max_drift + 1;
  const Real half_delay = Difference(*most, *least) / 2 + drifted;
  if (half_delay < 0) return false;

  Sample sample;
  sample.local = exchange.asked + *round_trip / 2;
  sample.offset = Duration(least->count() / 2 + most->count() / 2);
  sample.half_delay = Rounded(std::ceil(half_delay) + 1);
  const auto agree = [](const Sample& a, Duration offset, Real uncertainty) {
    return std::abs(Difference(a.offset, offset)) <= Nanoseconds(a.half_delay) + uncertainty;
  };
  if (!samples_.empty()) {
    const ClockOffset expected = Estimate(sample.local);
    if (!agree(sample, expected.offset, Nanoseconds(expected.uncertainty))) {
      if (!contradicting_.empty()) {
        const Sample& last = contradicting_.back();
        const Real apart = std::abs(Difference(sample.local, last.local)) * options_.max_drift;
        if (!agree(sample, last.offset, Nanoseconds(last.half_delay) + apart)) contradicting_.clear();
      }
      contradicting_.push_back(sample);
      if (contradicting_.size() < kContradictions) return true;
      samples_.clear();
      for (const Sample& kept : contradicting_) Keep(kept);
      ++resets_;
      contradicting_.clear();
      return true;
    }
  }
  contradicting_.clear();
  Keep(sample);
  return true;
}

void ClockOffsetEstimator::Keep(const Sample& sample) {
  samples_.push_back(sample);
  if (samples_.size() > std::max<std::size_t>(options_.window, 2)) samples_.pop_front();
  drift_ = BoundDrift();
}

ClockOffsetEstimator::Drift ClockOffsetEstimator::BoundDrift() const {
  const Drift widest{-options_.max_drift, options_.max_drift};
  Drift drift = widest;
  // Any two averages within the window, and the drift at any moment of it, differ by this at most.
  const Real wander = static_cast<Real>(options_.drift_wander) *
                      std::abs(Difference(samples_.back().local, samples_.front().local)) / 1e9L;
  for (std::size_t j = 1; j < samples_.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const Real time = Difference(samples_[j].local, samples_[i].local);
      if (time <= 0) continue;
      const Real change = Difference(samples_[j].offset, samples_[i].offset);
      const Real slack = Nanoseconds(samples_[i].half_delay) + Nanoseconds(samples_[j].half_delay);
      drift.least = std::max(drift.least, static_cast<double>((change - slack) / time - wander));
      drift.most = std::min(drift.most, static_cast<double>((change + slack) / time + wander));
    }
  }
  return drift.least <= drift.most ? drift : widest;  // empty range: the drift changes more than was assumed
}

ClockOffset ClockOffsetEstimator::Estimate(Time local) const {
  // Outside the window the drift may change further.
  const Real beyond =
      std::max({Real{0}, Difference(local, samples_.back().local), Difference(samples_.front().local, local)});
  const double middle = (drift_.least + drift_.most) / 2;
  const double half = (drift_.most - drift_.least) / 2 + options_.drift_wander * static_cast<double>(beyond / 1e9L);

  // Relative to the newest offset, so that small numbers remain.
  const Duration base = samples_.back().offset;
  Real least = -INFINITY;
  Real most = INFINITY;
  Real tightest_middle = 0;
  Real tightest = INFINITY;
  for (const Sample& sample : samples_) {
    const Real age = Difference(local, sample.local);
    const Real offset = Difference(sample.offset, base) + age * middle;
    const Real uncertainty = Nanoseconds(sample.half_delay) + std::abs(age) * half;
    least = std::max(least, offset - uncertainty);
    most = std::min(most, offset + uncertainty);
    if (uncertainty < tightest) {
      tightest = uncertainty;
      tightest_middle = offset;
    }
  }
  if (least > most) {  // The assumptions do not hold: only the exchange with the least delay counts.
    least = tightest_middle - tightest;
    most = tightest_middle + tightest;
  }
  ClockOffset result;
  const Time sum = Later(Time{base.count()}, Rounded(std::floor((least + most) / 2)));
  result.offset = Duration(sum.nanoseconds);
  result.uncertainty = Rounded(std::ceil((most - least) / 2) + 1);
  result.drift = middle;
  result.drift_uncertainty = half;
  return result;
}

std::optional<ClockOffset> ClockOffsetEstimator::At(Time local) const {
  if (samples_.empty()) return std::nullopt;
  return Estimate(local);
}

}  // namespace hgros
