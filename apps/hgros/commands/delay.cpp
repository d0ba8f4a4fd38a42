#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/timestamp.pb.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "commands/commands.hpp"
#include "commands/measure_command.hpp"
#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/session/synchronizer.hpp"
#include "robot/overview.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

// Receives channels, and matches their messages as a Synchronizer does.
struct Matches {
  struct Channel {
    std::shared_ptr<const MessageSchema> schema;
    std::shared_ptr<const DynamicSchema> type;
    std::uint64_t received = 0;
    std::uint64_t unreadable = 0;
    Measurements after_ns;  // The first stamp of each set.
  };

  Matches(Session& session, const std::vector<std::string>& names, std::chrono::nanoseconds tolerance)
      : matcher(names.size(), {.tolerance = tolerance}), channels(names.size()) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto push = [this, i](const RawMessage& message, const MessageInfo& info) { Push(i, message, info); };
      subscriptions.push_back(session.FromAnyRaw(names[i], Invoke::kSerial, push));
    }
  }

  // The field `timestamp`; without one, when the message was published. None: the message cannot be read.
  static std::optional<Time> StampIn(Channel& channel, const RawMessage& message, const MessageInfo& info) {
    std::string fault;
    if (message.schema != channel.schema) {
      channel.schema = message.schema;
      channel.type = DynamicSchema::Build(*message.schema, fault);
    }
    const auto read = channel.type == nullptr ? nullptr : channel.type->Read(message.data.bytes, fault);
    if (read == nullptr && message.schema->encoding == Encoding::kProtobuf) return std::nullopt;
    const auto* const field = read == nullptr ? nullptr : read->GetDescriptor()->FindFieldByName("timestamp");
    google::protobuf::Timestamp stamp;
    if (field == nullptr || field->is_repeated() || field->message_type() == nullptr ||
        !stamp.ParseFromString(read->GetReflection()->GetMessage(*read, field).SerializeAsString())) {
      return Time{info.publish_time_ns};
    }
    return StampOf(stamp);
  }

  void Push(std::size_t index, const RawMessage& message, const MessageInfo& info) {
    const std::scoped_lock lock(mutex);
    ++channels[index].received;
    const std::optional<Time> stamp = StampIn(channels[index], message, info);
    if (!stamp) {
      ++channels[index].unreadable;
      return;
    }
    const auto set = matcher.Push(index, *stamp, {});
    if (!set) return;
    const Time first = std::ranges::min(*set, {}, &StampMatcher<std::monostate>::Stamped::stamp).stamp;
    for (std::size_t i = 0; i < set->size(); ++i) {
      channels[i].after_ns.Add(static_cast<double>(((*set)[i].stamp - first).count()));
    }
  }

  std::mutex mutex;
  StampMatcher<std::monostate> matcher;  // Guarded by mutex, like the next one.
  std::vector<Channel> channels;
  std::vector<Subscription> subscriptions;  // They end first.
};

class Delay final : public MeasureCommand {
 public:
  void Declare(Arguments& arguments) override {
    MeasureCommand::Declare(arguments);
    arguments.Option("--match", "SECONDS", match_s_,
                     "Receive, and match messages of the channels whose stamps are at most this far apart", true);
  }
  int Run(Surroundings& surroundings) override {
    return match_s_ ? Match(surroundings) : MeasureCommand::Run(surroundings);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows once a second how long messages take to each node that receives them, since the node began: on the "
           "way from publish to the receiving process, and in the node's queue. The receivers count this, so no "
           "message is received. --receive measures the way to this command instead. Differences between the clocks "
           "of hosts are corrected as far as they are known. --match shows how well a synchronizer of the channels "
           "would match: how many messages are in sets, and how far each stamp is after the first one of its set. For "
           "types without a field timestamp it takes the time of publishing.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros delay scan --once", "Shows how long messages take to each receiver."},
            {"hgros delay scan --receive -n 2", "Receives for two seconds, and shows how long messages take to here."},
            {"hgros delay scan camera --match 0.02", "Matches stamps that are at most 20 ms apart."}};
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
  [[nodiscard]] int Match(Surroundings& surroundings);
  [[nodiscard]] Cell Duration(bool known, std::int64_t ns) const {
    return known ? Cell(ns, DurationText(ns, exact())) : Cell();
  }

  std::optional<double> match_s_;
};

int Delay::Match(Surroundings& surroundings) {
  if (channels().size() < 2 || channels().size() > 9) throw UsageError("--match needs two to nine channels.");
  if (receives()) throw UsageError("Give --match or --receive, not both. --match receives, too.");
  Robot robot(robot_options(), surroundings);
  Matches matches(robot.session(), channels(), DurationOf(*match_s_));
  robot.SayUnpublished(channels());
  Records records(surroundings.console, robot_options().style,
                  {{"channel", "CHANNEL"},
                   {"received", "RECEIVED", true},
                   {"matched", "MATCHED", true},
                   {"dropped", "DROPPED", true},
                   {"after_min_ns", "AFTER MIN", true},
                   {"after_p50_ns", "P50", true, 7},
                   {"after_p99_ns", "P99", true, 7},
                   {"after_max_ns", "MAX", true, 7}});
  const int code = EachSecond(robot, [&] {
    bool any = false;
    const std::scoped_lock lock(matches.mutex);
    for (std::size_t i = 0; i < channels().size(); ++i) {
      const Measurements& after = matches.channels[i].after_ns;
      const MatchCounts& counts = matches.matcher.counts(i);
      const auto cell = [&](double ns) { return Duration(after.count() > 0, static_cast<std::int64_t>(ns)); };
      records.Add({channels()[i], matches.channels[i].received, counts.matched,
                   counts.unmatched + counts.overflowed + counts.late + matches.channels[i].unreadable,
                   cell(after.min()), cell(after.Quantile(0.5)), cell(after.Quantile(0.99)), cell(after.max())});
      any = any || counts.matched > 0;
    }
    records.End();
    return any;
  });
  if (code == kFailed) surroundings.console.Say("No messages of all channels have stamps that are as near as that.");
  return code;
}

}  // namespace

std::unique_ptr<Command> MakeDelay() { return std::make_unique<Delay>(); }

}  // namespace hgros::cli
