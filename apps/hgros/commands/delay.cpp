#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/measure_command.hpp"
#include "robot/overview.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

class Delay final : public MeasureCommand {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how long messages take to each node that receives them, since the node began: on the "
           "way from publish to the receiving process, and in the node's queue. The receivers count this, so no "
           "message is received. --receive measures the way to this command instead. Differences between the clocks "
           "of hosts are corrected as far as they are known.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros delay scan --once", "Shows how long messages take to each receiver."},
            {"hgros delay scan --receive -n 2", "Receives for two seconds, and shows how long messages take to here."}};
  }

 protected:
  [[nodiscard]] std::vector<Column> CountedColumns() const override {
    return std::vector<Column>{{"channel", "CHANNEL"}, {"node", "NODE"}} + UserColumns("PROCESS") +
           std::vector<Column>{{"transport_p50_ns", "TRANSPORT P50", true},
                               {"transport_p99_ns", "P99", true, 7},
                               {"wait_p50_ns", "WAIT P50", true},
                               {"wait_p99_ns", "P99", true, 7}};
  }
  void AddCounted(Console& /*console*/, Records& records, const AllCounters& counters,
                  const KnownChannel& channel) override {
    for (const ChannelUser& user : channel.subscribers) {
      const Snapshot::Channel* counts = CountersOf(counters, user.session, channel.name);
      if (counts == nullptr) continue;
      const bool transported = counts->transport_p99_ns() != 0;
      for (const Snapshot::Node& node : counts->nodes()) {
        records.Add(std::vector<Cell>{channel.name, node.name()} + UserCells(user, false) +
                    std::vector<Cell>{Duration(transported, counts->transport_p50_ns()),
                                      Duration(transported, counts->transport_p99_ns()),
                                      Duration(node.run() > 0, node.wait_p50_ns()),
                                      Duration(node.run() > 0, node.wait_p99_ns())});
      }
    }
  }

  [[nodiscard]] std::vector<Column> ArrivedColumns() const override {
    return {{"received", "RECEIVED", true},
            {"delay_min_ns", "DELAY MIN", true},
            {"delay_p50_ns", "P50", true, 7},
            {"delay_p99_ns", "P99", true, 7},
            {"delay_max_ns", "MAX", true, 7}};
  }
  [[nodiscard]] std::vector<Cell> ArrivedCells(const Arrived& arrived) const override {
    const Measurements& delays = arrived.delays_ns;
    const auto cell = [&](double ns) { return Duration(delays.count() > 0, static_cast<std::int64_t>(ns)); };
    return {arrived.messages, cell(delays.min()), cell(delays.Quantile(0.5)), cell(delays.Quantile(0.99)),
            cell(delays.max())};
  }
  [[nodiscard]] Quantity Distribution() const override { return {"delay", Unit::kNanoseconds, &Arrived::delays_ns}; }

 private:
  [[nodiscard]] Cell Duration(bool known, std::int64_t ns) const {
    return known ? Cell(ns, DurationText(ns, exact())) : Cell();
  }
};

}  // namespace

std::unique_ptr<Command> MakeDelay() { return std::make_unique<Delay>(); }

}  // namespace hgros::cli
