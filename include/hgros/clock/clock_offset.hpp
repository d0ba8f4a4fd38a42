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
  Time asked;     ///< Local clock: the question is sent.
  Time received;  ///< Remote clock: the question arrives.
  Time answered;  ///< Remote clock: the answer is sent.
  Time got;       ///< Local clock: the answer arrives.
};

/// An estimate of a remote clock at one moment.
struct ClockOffset {
  Duration offset{0};       ///< Remote time minus local time.
  Duration uncertainty{0};  ///< Bound of the error of `offset`, as long as the assumptions hold.
  double drift = 0;         ///< Seconds that the remote clock gains in one local second.
  double drift_uncertainty = 0;
};

struct ClockOffsetOptions {
  std::size_t window = 64;     ///< Number of exchanges remembered; at least 2.
  double max_drift = 500e-6;   ///< Assumed maximum drift between the two clocks; NTP's bound.
  double drift_wander = 1e-9;  ///< Maximum change of the drift per second.
};

/// Estimates the offset of a remote clock from exchanges with it, for any delays, even if the two directions differ.
///
/// An exchange shows that the offset was within half its round trip around ((received - asked) + (answered - got)) / 2,
/// and nothing more: how the delay is shared between the two directions is unknown. Pairs of exchanges bound the drift,
/// and with the drift each remembered exchange bounds the offset now. The tightest bound, usually from the exchange
/// with the least delay, is the estimate. So the uncertainty is a bound, not a guess.
///
/// Thread safety: none; the owner guards it.
class HGROS_EXPORT ClockOffsetEstimator {
 public:
  explicit ClockOffsetEstimator(const ClockOffsetOptions& options = {}) : options_(options) {}

  /// Adds an exchange; exchanges come in order. Returns false and ignores an impossible one, whose answer comes before
  /// its question. An exchange that contradicts the others is set aside; after three in a row one of the clocks was
  /// set, and all exchanges before them are dropped.
  bool Add(const ClockExchange& exchange);

  /// The estimate at `local` by the local clock, usually now. Empty before the first exchange.
  [[nodiscard]] std::optional<ClockOffset> At(Time local) const;

  /// Number of times that one of the clocks was set.
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
  // The samples' mean drift over the window.
  [[nodiscard]] Drift BoundDrift() const;

  ClockOffsetOptions options_;
  std::deque<Sample> samples_;
  Drift drift_{};  // What samples_ say.
  std::deque<Sample> contradicting_;
  std::uint64_t resets_ = 0;
};

}  // namespace hgros
