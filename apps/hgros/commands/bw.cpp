#include <memory>
#include <set>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/measure_command.hpp"
#include "robot/channel_rates.hpp"
#include "terminal/console.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class Bw final : public MeasureCommand {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how many bytes per second are published on the channels: their rate times the mean "
           "size of the messages that publishers wrote for other sessions. No message is received. Messages that stay "
           "in their process are not written, so their size is unknown; --receive measures what arrives here.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros bw camera", "Shows the bytes per second of a channel, once a second."},
            {"hgros bw scan --receive --once", "Receives for a second, and shows the sizes of the messages."}};
  }

 protected:
  [[nodiscard]] std::vector<Column> CountedColumns() const override {
    return {{"channel", "CHANNEL"},
            {"bytes_per_second", "BANDWIDTH", true},
            {"mean_bytes", "MEAN SIZE", true},
            {"rate_hz", "RATE", true, 8}};
  }
  void AddCounted(Console& console, Records& records, const AllCounters& counters,
                  const KnownChannel& channel) override {
    const ChannelRate rate = rates_.Next(counters, channel);
    if (rate.publishers == 0) return;
    if (!rate.mean_bytes && said_.insert(channel.name).second) {
      console.Say("The size of messages on " + Visible(channel.name) +
                  " is unknown: nobody outside its process receives them. --receive measures it.");
    }
    records.Add({channel.name, rate.mean_bytes ? Bandwidth(rate.rate_hz * *rate.mean_bytes) : Cell(),
                 rate.mean_bytes ? Bytes(*rate.mean_bytes) : Cell(), Rate(rate.rate_hz)});
  }

  [[nodiscard]] std::vector<Column> ArrivedColumns() const override {
    return {{"bytes_per_second", "BANDWIDTH", true},
            {"mean_bytes", "MEAN SIZE", true},
            {"min_bytes", "MIN", true, 7},
            {"max_bytes", "MAX", true, 7},
            {"rate_hz", "RATE", true, 8}};
  }
  [[nodiscard]] std::vector<Cell> ArrivedCells(const Arrived& arrived) const override {
    const Measurements& sizes = arrived.sizes_bytes;
    const auto cell = [&](double bytes) { return sizes.count() == 0 ? Cell() : Bytes(bytes); };
    return {Bandwidth(static_cast<double>(arrived.bytes) / arrived.seconds), cell(sizes.Mean()), cell(sizes.min()),
            cell(sizes.max()), Rate(static_cast<double>(arrived.messages) / arrived.seconds)};
  }
  [[nodiscard]] Quantity Distribution() const override { return {"size", Unit::kBytes, &Arrived::sizes_bytes}; }

 private:
  [[nodiscard]] Cell Rate(double hertz) const { return {hertz, RateText(hertz, exact())}; }
  [[nodiscard]] Cell Bytes(double bytes) const { return {bytes, BytesText(bytes, exact())}; }
  [[nodiscard]] Cell Bandwidth(double bytes) const { return {bytes, BandwidthText(bytes, exact())}; }

  ChannelRates rates_;
  std::set<std::string> said_;  // Channels whose size is not known.
};

}  // namespace

std::unique_ptr<Command> MakeBw() { return std::make_unique<Bw>(); }

}  // namespace hgros::cli
