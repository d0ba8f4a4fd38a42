#pragma once

#include <memory>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// Carries hgros::SimulatedTime.
inline constexpr std::string_view kClockChannel = "clock";

/// Publishes a simulated clock, which all sessions of the domain with `time: simulated` follow, including this one. Its
/// state is sent on every change, to late subscribers, and ten times per second while the clock runs. Changes that
/// follow each other faster than they can be sent, or faster than a lossless subscriber makes room, are sent as one.
///
/// Publish one clock at a time: sessions that follow the first one report a second one in their log.
///
/// Threading: a thread of its own, which sleeps while the clock is paused. It runs inline nodes of the channel.
/// Lifetime: when it ends, the clocks that follow it stand still. The destructor waits for room at most 0.1 s. It may
/// outlive its session and then does nothing. Errors: throws TypeMismatch if the channel has another type.
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
