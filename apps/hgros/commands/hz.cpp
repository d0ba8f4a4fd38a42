#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "robot/arrivals.hpp"
#include "robot/channel_rates.hpp"
#include "robot/histogram.hpp"
#include "robot/measuring.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

class Hz final : public Command {
 public:
  void Declare(Arguments& arguments) override { options_.Declare(arguments); }
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how often messages are published on the channels: from the counters that publishers "
           "keep. No message is received, so the rates of images are right, too. --receive measures what arrives here "
           "instead: the intervals between messages, and at the end a histogram of the last 10,000.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros hz scan odometry", "Shows the rates of two channels, once a second."},
            {"hgros hz scan --receive -n 2", "Receives for two seconds, and shows the intervals between messages."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_.robot, surroundings);
    return options_.receive ? Receive(robot) : Count(robot);
  }

 private:
  [[nodiscard]] int Count(Robot& robot) const;
  [[nodiscard]] int Receive(Robot& robot) const;
  [[nodiscard]] Cell Rate(double hertz) const { return {hertz, RateText(hertz, options_.robot.style.exact)}; }

  MeasureOptions options_;
};

int Hz::Count(Robot& robot) const {
  Records records(robot.surroundings().console, options_.robot.style,
                  {{"channel", "CHANNEL"},
                   {"rate_hz", "RATE", true, 8},
                   {"publishers", "PUBLISHERS", true},
                   {"published", "PUBLISHED", true}});
  ChannelRates rates;
  (void)robot.Counters();
  WarnOfUnpublished(robot, options_.channels);
  return EverySecond(robot, options_, [&] {
    const AllCounters counters = robot.Counters();
    const std::vector<KnownChannel> channels = robot.Channels(true);
    const std::size_t before = records.size();
    for (const std::string& name : options_.channels) {
      const ChannelRate rate = rates.Next(counters, FindChannel(channels, name));
      if (rate.publishers > 0) records.Add({name, Rate(rate.rate_hz), rate.publishers, rate.published});
    }
    records.End();
    return records.size() > before;
  });
}

int Hz::Receive(Robot& robot) const {
  Console& console = robot.surroundings().console;
  const OutputStyle style = options_.robot.style;
  Records records(console, style,
                  {{"channel", "CHANNEL"},
                   {"rate_hz", "RATE", true, 8},
                   {"received", "RECEIVED", true},
                   {"interval_min_ns", "INTERVAL MIN", true},
                   {"interval_p50_ns", "P50", true, 7},
                   {"interval_p99_ns", "P99", true, 7},
                   {"interval_max_ns", "MAX", true, 7}});
  const auto cell = [&](const Measurements& all, double ns) {
    return all.count() == 0 ? Cell() : Cell(ns, DurationText(static_cast<std::int64_t>(ns), style.exact));
  };
  std::vector<std::unique_ptr<Arrivals>> arrivals;
  for (const std::string& name : options_.channels) arrivals.push_back(std::make_unique<Arrivals>(robot, name));
  WarnOfUnpublished(robot, options_.channels);
  const int code = EverySecond(robot, options_, [&] {
    bool any = false;
    for (const auto& channel : arrivals) {
      const Arrived arrived = channel->Report();
      const Measurements& intervals = arrived.intervals_ns;
      any = any || arrived.sizes_bytes.count() > 0;
      records.Add({channel->channel(), Rate(static_cast<double>(arrived.messages) / arrived.seconds), arrived.messages,
                   cell(intervals, intervals.min()), cell(intervals, intervals.Quantile(0.5)),
                   cell(intervals, intervals.Quantile(0.99)), cell(intervals, intervals.max())});
    }
    records.End();
    return any;
  });
  for (const auto& channel : arrivals) {
    WriteHistogram(console, style, channel->channel(), "interval", Unit::kNanoseconds, channel->Report().intervals_ns);
  }
  return code;
}

}  // namespace

std::unique_ptr<Command> MakeHz() { return std::make_unique<Hz>(); }

}  // namespace hgros::cli
