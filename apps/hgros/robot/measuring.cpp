#include "robot/measuring.hpp"

#include <algorithm>
#include <chrono>

#include "hgros/base/names.hpp"
#include "robot/robot.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

void MeasureOptions::Declare(Arguments& arguments) {
  arguments.Positional({"CHANNEL", "", "Channels to measure", ValueKind::kChannel, {}, true}, channels);
  arguments.Flag("--once", once, "End after the first report");
  arguments.Option("-n,--count", "N", count, "End after N reports");
  arguments.Flag("--receive", receive,
                 "Receive the messages and measure what arrives here, with a histogram at the end");
  robot.Declare(arguments);
}

void WarnOfUnpublished(Robot& robot, const std::vector<std::string>& channels) {
  std::vector<std::string> published;
  for (const KnownChannel& channel : robot.Channels(true)) {
    if (!channel.publishers.empty()) published.push_back(channel.name);
  }
  for (const std::string& name : channels) {
    if (std::ranges::find(published, name) != published.end()) continue;
    const std::string nearest = NearestName(name, published);
    robot.surroundings().console.Say("Nobody publishes on " + Visible(name) + " yet." +
                                     (nearest.empty() ? "" : " Did you mean " + Visible(nearest) + "?"));
  }
}

KnownChannel FindChannel(const std::vector<KnownChannel>& channels, const std::string& name) {
  const auto found = std::ranges::find(channels, name, &KnownChannel::name);
  if (found != channels.end()) return *found;
  KnownChannel none;
  none.name = name;
  return none;
}

int EverySecond(Robot& robot, const MeasureOptions& options, const std::function<bool()>& report) {
  using std::chrono::steady_clock;
  constexpr std::chrono::seconds kPeriod{1};
  // The counters come once a second, the first ones when this command subscribes.
  constexpr std::chrono::milliseconds kLate{100};
  const std::uint64_t count = options.once ? 1 : options.count.value_or(0);
  const auto start = steady_clock::now();
  const auto end = start + options.robot.Timeout(std::chrono::hours(24 * 365));
  auto next = options.receive ? start + kPeriod : start;
  bool shown = false;
  for (std::uint64_t reports = 0; count == 0 || reports < count; ++reports) {
    Pause& pause = robot.surroundings().pause;
    while (steady_clock::now() < std::min(next, end)) {
      if (pause.Until(std::min(next, end)) == Pause::End::kInterrupted) return kDone;
    }
    if (next >= end) return kTimedOut;
    shown = report() || shown;
    next += reports == 0 && !options.receive ? kPeriod + kLate : kPeriod;
  }
  return shown ? kDone : kFailed;
}

}  // namespace hgros::cli
