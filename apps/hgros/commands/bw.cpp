#include <memory>
#include <set>
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
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class Bw final : public Command {
 public:
  void Declare(Arguments& arguments) override { options_.Declare(arguments); }
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how many bytes per second are published on the channels: their rate times the mean "
           "size of the messages that publishers wrote for other sessions. No message is received. Messages that stay "
           "in their process are not written, so their size is unknown; --receive measures what arrives here.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros bw camera", "Shows the bytes per second of a channel, once a second."},
            {"hgros bw scan --receive --once", "Receives for a second, and shows the sizes of the messages."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_.robot, surroundings);
    return options_.receive ? Receive(robot) : Count(robot);
  }

 private:
  [[nodiscard]] int Count(Robot& robot) const;
  [[nodiscard]] int Receive(Robot& robot) const;
  [[nodiscard]] Cell Rate(double hertz) const { return {hertz, RateText(hertz, options_.robot.style.exact)}; }
  [[nodiscard]] Cell Bytes(double bytes) const { return {bytes, BytesText(bytes, options_.robot.style.exact)}; }
  [[nodiscard]] Cell Bandwidth(double bytes) const { return {bytes, BandwidthText(bytes, options_.robot.style.exact)}; }

  MeasureOptions options_;
};

int Bw::Count(Robot& robot) const {
  Console& console = robot.surroundings().console;
  Records records(console, options_.robot.style,
                  {{"channel", "CHANNEL"},
                   {"bytes_per_second", "BANDWIDTH", true},
                   {"mean_bytes", "MEAN SIZE", true},
                   {"rate_hz", "RATE", true, 8}});
  ChannelRates rates;
  std::set<std::string> said;
  (void)robot.Counters();
  WarnOfUnpublished(robot, options_.channels);
  return EverySecond(robot, options_, [&] {
    const AllCounters counters = robot.Counters();
    const std::vector<KnownChannel> channels = robot.Channels(true);
    const std::size_t before = records.size();
    for (const std::string& name : options_.channels) {
      const ChannelRate rate = rates.Next(counters, FindChannel(channels, name));
      if (rate.publishers == 0) continue;
      if (!rate.mean_bytes && said.insert(name).second) {
        console.Say("The size of messages on " + Visible(name) +
                    " is unknown: nobody outside its process receives them. --receive measures it.");
      }
      records.Add({name, rate.mean_bytes ? Bandwidth(rate.rate_hz * *rate.mean_bytes) : Cell(),
                   rate.mean_bytes ? Bytes(*rate.mean_bytes) : Cell(), Rate(rate.rate_hz)});
    }
    records.End();
    return records.size() > before;
  });
}

int Bw::Receive(Robot& robot) const {
  Console& console = robot.surroundings().console;
  const OutputStyle style = options_.robot.style;
  Records records(console, style,
                  {{"channel", "CHANNEL"},
                   {"bytes_per_second", "BANDWIDTH", true},
                   {"mean_bytes", "MEAN SIZE", true},
                   {"min_bytes", "MIN", true, 7},
                   {"max_bytes", "MAX", true, 7},
                   {"rate_hz", "RATE", true, 8}});
  std::vector<std::unique_ptr<Arrivals>> arrivals;
  for (const std::string& name : options_.channels) arrivals.push_back(std::make_unique<Arrivals>(robot, name));
  WarnOfUnpublished(robot, options_.channels);
  const int code = EverySecond(robot, options_, [&] {
    bool any = false;
    for (const auto& channel : arrivals) {
      const Arrived arrived = channel->Report();
      const Measurements& sizes = arrived.sizes_bytes;
      const auto cell = [&](double bytes) { return sizes.count() == 0 ? Cell() : Bytes(bytes); };
      any = any || sizes.count() > 0;
      records.Add({channel->channel(), Bandwidth(static_cast<double>(arrived.bytes) / arrived.seconds),
                   cell(sizes.Mean()), cell(sizes.min()), cell(sizes.max()),
                   Rate(static_cast<double>(arrived.messages) / arrived.seconds)});
    }
    records.End();
    return any;
  });
  for (const auto& channel : arrivals) {
    WriteHistogram(console, style, channel->channel(), "size", Unit::kBytes, channel->Report().sizes_bytes);
  }
  return code;
}

}  // namespace

std::unique_ptr<Command> MakeBw() { return std::make_unique<Bw>(); }

}  // namespace hgros::cli
