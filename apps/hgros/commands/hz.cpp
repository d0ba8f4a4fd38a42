#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/measure_command.hpp"
#include "robot/channel_rates.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

class Hz final : public MeasureCommand {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how often messages are published on the channels: from the counters that publishers "
           "keep. No message is received, so the rates of images are right, too. --receive measures what arrives here "
           "instead: the intervals between messages, and at the end a histogram of the last 10,000.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros hz scan odometry", "Shows the rates of two channels, once a second."},
            {"hgros hz scan --receive -n 2", "Receives for two seconds, and shows the intervals between messages."}};
  }

 protected:
  [[nodiscard]] std::vector<Column> CountedColumns() const override {
    return {{"channel", "CHANNEL"},
            {"rate_hz", "RATE", true, 8},
            {"publishers", "PUBLISHERS", true},
            {"published", "PUBLISHED", true}};
  }
  void AddCounted(Console& /*console*/, Records& records, const AllCounters& counters,
                  const KnownChannel& channel) override {
    const ChannelRate rate = rates_.Next(counters, channel);
    if (rate.publishers > 0) records.Add({channel.name, Rate(rate.rate_hz), rate.publishers, rate.published});
  }

  [[nodiscard]] std::vector<Column> ArrivedColumns() const override {
    return {{"rate_hz", "RATE", true, 8},
            {"received", "RECEIVED", true},
            {"interval_min_ns", "INTERVAL MIN", true},
            {"interval_p50_ns", "P50", true, 7},
            {"interval_p99_ns", "P99", true, 7},
            {"interval_max_ns", "MAX", true, 7}};
  }
  [[nodiscard]] std::vector<Cell> ArrivedCells(const Arrived& arrived) const override {
    const Measurements& all = arrived.intervals_ns;
    const auto cell = [&](double ns) {
      return all.count() == 0 ? Cell() : Cell(ns, DurationText(static_cast<std::int64_t>(ns), exact()));
    };
    return {Rate(static_cast<double>(arrived.messages) / arrived.seconds),
            arrived.messages,
            cell(all.min()),
            cell(all.Quantile(0.5)),
            cell(all.Quantile(0.99)),
            cell(all.max())};
  }
  [[nodiscard]] Quantity Distribution() const override {
    return {"interval", Unit::kNanoseconds, &Arrived::intervals_ns};
  }

 private:
  [[nodiscard]] Cell Rate(double hertz) const { return {hertz, RateText(hertz, exact())}; }

  ChannelRates rates_;
};

}  // namespace

std::unique_ptr<Command> MakeHz() { return std::make_unique<Hz>(); }

}  // namespace hgros::cli
