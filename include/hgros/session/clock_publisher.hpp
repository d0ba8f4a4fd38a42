#pragma once

#include <memory>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// Carries hgros::SimulatedTime.
inline constexpr std::string_view kClockChannel = "clock";

/// Makes a simulated clock that of all sessions of the domain that say `time: simulated`, this one included: each is
/// told of every change, late ones of how it stands, and all ten times per second while it runs. Changes that follow
/// each other faster than they are sent, or than a lossless subscriber makes room, are sent as one.
///
/// One clock is published at a time; sessions that follow the first report a second one in their log.
///
/// Threading: a thread of its own, which sleeps while the clock is paused. It runs nodes on the channel that are
/// inline. Lifetime: when it ends, the clocks that follow stand still; its end waits for room for 0.1 s at most. It may
/// outlive its session, and then does nothing. Errors: throws TypeMismatch if the channel carries something else.
class HGROS_EXPORT ClockPublisher {
 public:
  ClockPublisher(Session& session, std::shared_ptr<SimulatedClock> clock);
  ClockPublisher(const ClockPublisher&) = delete;
  ClockPublisher& operator=(const ClockPublisher&) = delete;
  ~ClockPublisher();

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
