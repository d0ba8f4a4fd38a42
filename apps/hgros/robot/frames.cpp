#include "robot/frames.hpp"

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include <hgros/SimulatedTime.pb.h>

#include "hgros/clock/derived_clocks.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "robot/domains.hpp"
#include "terminal/pause.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

Frames::Frames(Robot& robot)
    : robot_(robot), transforms_(robot.session(), {.on_received = [&robot] { robot.surroundings().pause.Wake(); }}) {
  (void)transforms_.tree();  // Subscribes.
  if (Sends(kClockChannel)) HearClock();
}

void Frames::HearClock() {
  clock_messages_ =
      robot_.session().FromAny<SimulatedTime>(kClockChannel, Invoke::kSerial, [this](const SimulatedTime& time) {
        const auto clock = SimulatedClock::Paused(Time{time.time_ns()});
        if (!time.paused() && !time.ended() && time.rate() > 0 && time.rate() <= SimulatedClock::kMostRate) {
          clock->SetRate(time.rate());
          clock->Resume();
        }
        const std::scoped_lock lock(clock_mutex_);
        clock_ = clock;
      });
}

Time Frames::Now() const {
  const std::scoped_lock lock(clock_mutex_);
  return clock_ ? clock_->Now() : robot_.session().clock()->Now();
}

bool Frames::Sends(std::string_view channel) const {
  for (const KnownChannel& known : robot_.Channels(true)) {
    if (known.name == channel) return !known.publishers.empty();
  }
  return false;
}

bool Frames::AnySender() const { return Sends(kTransformsChannel) || Sends(kStaticTransformsChannel); }

// Static transforms come at once: they are complete when nothing new has come for a moment.
void Frames::Collect(std::chrono::nanoseconds time) {
  if (!AnySender()) return;
  constexpr std::chrono::milliseconds kQuiet{150};
  const bool moving = Sends(kTransformsChannel);
  Pause& pause = robot_.surroundings().pause;
  const auto deadline = DeadlineIn(time);
  for (;;) {
    const bool wait_for_quiet = !moving && !tree().Edges().empty();
    const auto until = wait_for_quiet ? std::min(deadline, DeadlineIn(kQuiet)) : deadline;
    if (pause.Until(until) != Pause::End::kWoken) return;
  }
}

void WriteFrames(Robot& robot, const RobotOptions& options) {
  Frames frames(robot);
  frames.Collect(options.Timeout(std::chrono::seconds(1)));
  if (!frames.AnySender()) {
    if (robot.Channels(true).empty()) {
      SayNone(robot, "transforms");
    } else {
      robot.surroundings().console.Say("No session sends transforms. Sessions of other hosts are met with --connect.");
    }
  }
  const std::vector<EdgeSnapshot> edges = frames.tree().Edges();
  const Time now = frames.Now();  // After the edges, so that a transform that just came is not younger than 0 s.
  Records records(robot.surroundings().console, options.style,
                  {{"frame", "FRAME"},
                   {"parent", ""},
                   {"kind", "KIND"},
                   {"rate_hz", "RATE", true},
                   {"age_ns", "AGE", true},
                   {"publisher", "PUBLISHER"}});
  std::map<std::string, std::size_t> depths;
  for (const EdgeSnapshot& edge : edges) {
    const auto [parent, is_root] = depths.try_emplace(edge.parent, 0);
    if (is_root) records.Add({edge.parent, {}, {}, {}, {}, {}});
    const std::size_t depth = parent->second + 1;
    depths[edge.child] = depth;
    const std::int64_t age = (now - edge.newest).count();
    const double rate = edge.RateHz();
    records.Add({Cell(edge.child, std::string(2 * depth, ' ') + Visible(edge.child)), edge.parent,
                 edge.is_static ? "static" : "moving",
                 edge.is_static ? Cell() : Cell(rate, RateText(rate, options.style.exact)),
                 edge.is_static ? Cell() : Cell(age, DurationText(age, options.style.exact)), edge.publisher});
  }
  records.End();
}

}  // namespace hgros::cli
