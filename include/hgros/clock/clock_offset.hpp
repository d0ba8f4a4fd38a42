#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

/// One question and its answer between two clocks, as in NTP (RFC 5905, section 8).
struct ClockExchange {
  Time asked;     ///< By the local clock: the question leaves.
  Time received;  ///< By the remote clock: it arrives there.
  Time answered;  ///< By the remote clock: the answer leaves.
  Time got;       ///< By the local clock: it arrives here.
};

/// What is known of a remote clock at some moment.
struct ClockOffset {
  Duration offset{0};       ///< Remote time minus local time.
  Duration uncertainty{0};  ///< The true offset is no farther from `offset` than this, as long as the assumptions hold.
  double drift = 0;         ///< Seconds that the remote clock gains in one local second.
  double drift_uncertainty = 0;
};

struct ClockOffsetOptions {
  std::size_t window = 64;     ///< Exchanges that are remembered; at least 2.
  double max_drift = 500e-6;   ///< Assumed of the two clocks against each other; what NTP grants every clock.
  double drift_wander = 1e-9;  ///< By how much the drift may change in one second.
};

/// Estimates the offset of a remote clock from exchanges with it, whatever the delays are and however unlike the two
/// ways.
///
/// An exchange says that the offset lay within half its round trip around ((received - asked) + (answered - got)) / 2,
/// and nothing more: how the delay is shared between the two ways cannot be known. Pairs of exchanges bound the drift,
/// and with the drift each remembered exchange bounds the offset now; the tightest bound, mostly that of the least
/// delayed exchange, is the estimate. So the uncertainty is one that holds, not a guess.
///
/// Thread safety: none.
class HGROS_EXPORT ClockOffsetEstimator {
 public:
  explicit ClockOffsetEstimator(const ClockOffsetOptions& options = {}) : options_(options) {}

  /// Takes exchanges in their order. Returns false, and forgets it, for one that cannot be: an answer before its
  /// question. One that contradicts the others is set apart; when three in a row do, one of the clocks has been set,
  /// and all before them are forgotten.
  bool Add(const ClockExchange& exchange);

  /// At `local` by the local clock, usually the present. Empty before the first exchange.
  [[nodiscard]] std::optional<ClockOffset> At(Time local) const;

  /// How often one of the clocks was set.
  [[nodiscard]] std::uint64_t resets() const noexcept { return resets_; }

 private:
  // Half the round trip around the offset, at the middle of the exchange.
  struct Sample {
    Time local;
    Duration offset;
    Duration half_delay;
  };
  struct Drift {
    double least;
    double most;
  };

  void Keep(const Sample& sample);
  [[nodiscard]] ClockOffset Estimate(Time local) const;
  // What the samples' drift was on the average of the window.
  [[nodiscard]] Drift BoundDrift() const;

  ClockOffsetOptions options_;
  std::deque<Sample> samples_;
  Drift drift_{};  // of samples_
  std::deque<Sample> contradicting_;
  std::uint64_t resets_ = 0;
};

}  // namespace hgros
