#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "robot/arrivals.hpp"
#include "robot/histogram.hpp"
#include "robot/measuring.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

class Delay final : public Command {
 public:
  void Declare(Arguments& arguments) override { options_.Declare(arguments); }
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how long messages take to each node that receives them, since the node began: on the "
           "way from publish to the receiving process, and in the node's queue. The receivers count this, so no "
           "message "
           "is received. --receive measures the way to this command instead. Differences between the clocks of hosts "
           "are corrected as far as they are known.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros delay scan --once", "Shows how long messages take to each receiver."},
            {"hgros delay scan --receive -n 2", "Receives for two seconds, and shows how long messages take to here."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_.robot, surroundings);
    return options_.receive ? Receive(robot) : Count(robot);
  }

 private:
  [[nodiscard]] int Count(Robot& robot) const;
  [[nodiscard]] int Receive(Robot& robot) const;
  [[nodiscard]] Cell Duration(bool known, std::int64_t ns) const {
    return known ? Cell(ns, DurationText(ns, options_.robot.style.exact)) : Cell();
  }

  MeasureOptions options_;
};

int Delay::Count(Robot& robot) const {
  Records records(robot.surroundings().console, options_.robot.style,
                  {{"channel", "CHANNEL"},
                   {"node", "NODE"},
                   {"process", "PROCESS"},
                   {"session", ""},
                   {"transport_p50_ns", "TRANSPORT P50", true},
                   {"transport_p99_ns", "P99", true, 7},
                   {"wait_p50_ns", "WAIT P50", true},
                   {"wait_p99_ns", "P99", true, 7}});
  (void)robot.Counters();
  WarnOfUnpublished(robot, options_.channels);
  return EverySecond(robot, options_, [&] {
    const AllCounters counters = robot.Counters();
    const std::vector<KnownChannel> channels = robot.Channels(true);
    const std::size_t before = records.size();
    for (const std::string& name : options_.channels) {
      for (const ChannelUser& user : FindChannel(channels, name).subscribers) {
        const Snapshot::Channel* counts = CountersOf(counters, user.session, name);
        if (counts == nullptr) continue;
        for (const Snapshot::Node& node : counts->nodes()) {
          records.Add({name, node.name(), ShortName(user, false), user.session.ToString(),
                       Duration(counts->transport_p99_ns() != 0, counts->transport_p50_ns()),
                       Duration(counts->transport_p99_ns() != 0, counts->transport_p99_ns()),
                       Duration(node.run() > 0, node.wait_p50_ns()), Duration(node.run() > 0, node.wait_p99_ns())});
        }
      }
    }
    records.End();
    return records.size() > before;
  });
}

int Delay::Receive(Robot& robot) const {
  Console& console = robot.surroundings().console;
  const OutputStyle style = options_.robot.style;
  Records records(console, style,
                  {{"channel", "CHANNEL"},
                   {"received", "RECEIVED", true},
                   {"delay_min_ns", "DELAY MIN", true},
                   {"delay_p50_ns", "P50", true, 7},
                   {"delay_p99_ns", "P99", true, 7},
                   {"delay_max_ns", "MAX", true, 7}});
  std::vector<std::unique_ptr<Arrivals>> arrivals;
  for (const std::string& name : options_.channels) arrivals.push_back(std::make_unique<Arrivals>(robot, name));
  WarnOfUnpublished(robot, options_.channels);
  const int code = EverySecond(robot, options_, [&] {
    bool any = false;
    for (const auto& channel : arrivals) {
      const Arrived arrived = channel->Report();
      const Measurements& delays = arrived.delays_ns;
      const auto cell = [&](double ns) { return Duration(delays.count() > 0, static_cast<std::int64_t>(ns)); };
      any = any || arrived.sizes_bytes.count() > 0;
      records.Add({channel->channel(), arrived.messages, cell(delays.min()), cell(delays.Quantile(0.5)),
                   cell(delays.Quantile(0.99)), cell(delays.max())});
    }
    records.End();
    return any;
  });
  for (const auto& channel : arrivals) {
    WriteHistogram(console, style, channel->channel(), "delay", Unit::kNanoseconds, channel->Report().delays_ns);
  }
  return code;
}

}  // namespace

std::unique_ptr<Command> MakeDelay() { return std::make_unique<Delay>(); }

}  // namespace hgros::cli
