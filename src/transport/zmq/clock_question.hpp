#pragma once

#include <optional>

#include "hgros/clock/clock_offset.hpp"
#include "hgros/control.pb.h"

namespace hgros::zmq {

/// Asks one peer for the time of its wall clock, together with the heartbeats.
///
/// Thread safety: none.
class ClockQuestion {
 public:
  void Ask(wire::Heartbeat& heartbeat, Time now);
  /// The exchange, if the heartbeat answers the latest question; nullopt if it does not, or was read before.
  [[nodiscard]] std::optional<ClockExchange> Read(const wire::Heartbeat& heartbeat, Time got);

 private:
  Time asked_;  // 0: every question is answered.
};

/// The answer to a heartbeat that asks; nullopt if it does not.
[[nodiscard]] std::optional<wire::Heartbeat> AnswerTo(const wire::Heartbeat& heartbeat, Time received);

}  // namespace hgros::zmq
