#include "commands/measure_command.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "hgros/base/names.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kPeriod{1};
// The counters come once a second, the first ones when this command subscribes.
constexpr std::chrono::milliseconds kLate{100};

// Calls `report` every second from `next` on, `count` times if it is not 0. It returns whether there was anything to
// show.
int EverySecond(Pause& pause, std::uint64_t count, steady_clock::time_point next, steady_clock::time_point end,
                const std::function<bool()>& report) {
  bool shown = false;
  for (std::uint64_t reports = 0; count == 0 || reports < count; ++reports, next += kPeriod) {
    if (!pause.SleepUntil(std::min(next, end))) return kDone;
    if (next >= end) return kTimedOut;
    shown = report() || shown;
    if (reports == 0) next += kLate;
  }
  return shown ? kDone : kFailed;
}

}  // namespace

void MeasureCommand::Declare(Arguments& arguments) {
  arguments.Positional({"CHANNEL", "", "Channels to measure", ValueKind::kChannel, {}, true}, channels_);
  arguments.Count(count_, "End after the first report", "End after N reports");
  arguments.Flag("--receive", receive_,
                 "Receive the messages and measure what arrives here, with a histogram at the end");
  robot_options_.Declare(arguments);
}

int MeasureCommand::Run(Surroundings& surroundings) {
  for (const std::string& name : channels_) RequireChannelName(name);
  Robot robot(robot_options_, surroundings);
  return receive_ ? Receive(robot) : Count(robot);
}

int MeasureCommand::EachSecond(Robot& robot, const std::function<bool()>& report) const {
  const auto start = steady_clock::now();
  const auto end = start + robot_options_.Timeout(std::chrono::hours(24 * 365));
  return EverySecond(robot.surroundings().pause, count_.value_or(0), start + kPeriod, end, report);
}

int MeasureCommand::Count(Robot& robot) {
  Console& console = robot.surroundings().console;
  Records records(console, robot_options_.style, CountedColumns());
  (void)robot.Counters();
  robot.SayUnpublished(channels_);
  const auto start = steady_clock::now();
  const auto end = start + robot_options_.Timeout(std::chrono::hours(24 * 365));
  bool first = true;
  return EverySecond(robot.surroundings().pause, count_.value_or(0), start, end, [&] {
    const AllCounters counters = robot.Counters();
    const std::vector<KnownChannel> channels = robot.Channels(true);
    const std::size_t before = records.size();
    std::string uncounted;
    for (const std::string& name : channels_) {
      const KnownChannel channel = ChannelNamed(channels, name);
      const std::size_t before_it = records.size();
      AddCounted(console, records, counters, channel);
      if (records.size() > before_it || channel.publishers.empty()) continue;
      uncounted += (uncounted.empty() ? "" : ", ") + Visible(name);
    }
    records.End();
    if (std::exchange(first, false) && !uncounted.empty()) {
      console.Say("Nobody counts this of " + uncounted + " now. --receive measures what arrives here.");
    }
    return records.size() > before;
  });
}

int MeasureCommand::Receive(Robot& robot) const {
  Console& console = robot.surroundings().console;
  std::vector<Column> columns = ArrivedColumns();
  columns.insert(columns.begin(), {"channel", "CHANNEL"});
  Records records(console, robot_options_.style, std::move(columns));
  std::vector<std::unique_ptr<Arrivals>> arrivals;
  for (const std::string& name : channels_) arrivals.push_back(std::make_unique<Arrivals>(robot, name));
  robot.SayUnpublished(channels_);
  const int code = EachSecond(robot, [&] {
    bool any = false;
    for (const auto& channel : arrivals) {
      const Arrived arrived = channel->Report();
      any = any || arrived.sizes_bytes.count() > 0;
      std::vector<Cell> cells = ArrivedCells(arrived);
      cells.insert(cells.begin(), channel->channel());
      records.Add(std::move(cells));
    }
    records.End();
    return any;
  });
  std::string silent;
  for (const auto& channel : arrivals) {
    if (channel->Report().sizes_bytes.count() == 0)
      silent += (silent.empty() ? "" : ", ") + Visible(channel->channel());
  }
  if (code != kDone && !silent.empty()) console.Say("No message of " + silent + " came.");
  const Quantity quantity = Distribution();
  for (const auto& channel : arrivals) {
    WriteHistogram(console, robot_options_.style, channel->channel(), quantity.name, quantity.unit,
                   channel->Report().*quantity.values);
  }
  return code;
}

}  // namespace hgros::cli
