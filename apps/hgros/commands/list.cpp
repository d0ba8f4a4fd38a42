#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "robot/domains.hpp"
#include "robot/frames.hpp"
#include "robot/offered_params.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

class List final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Choice("WHAT", what_, {"channels", "sessions", "nodes", "services", "params", "frames"},
                     "What to list; without it the channels");
    arguments.Flag("-a,--all", all_,
                   "Also what belongs to the library itself: channels that begin with hgros/ or params/");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Lists what this command can reach: the sessions of this user on this host in the same domain, and those "
           "behind "
           "--connect. Rates come from the counters of the publishers; no message is received.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros list", "Lists all channels with type, publishers, subscribers and rate."},
            {"hgros list nodes --json", "Lists all nodes, one JSON object per line."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void ListChannels(Robot& robot) const;
  void ListSessions(Robot& robot) const;
  void ListNodes(Robot& robot) const;
  void ListServices(Robot& robot) const;
  void End(Records& records, Robot& robot) const {
    records.End();
    if (records.size() == 0) SayNone(robot, what_);
  }

  std::string what_ = "channels";
  bool all_ = false;
  RobotOptions options_;
};

Cell RateOf(const ChannelTotals& totals, const OutputStyle& style) {
  if (!totals.known) return {};
  return {totals.rate_hz, totals.rate_hz == 0 ? "-" : RateText(totals.rate_hz, style.exact)};
}

void List::ListChannels(Robot& robot) const {
  const AllCounters counters = robot.Counters();
  const std::vector<KnownChannel> channels = robot.Channels(all_);
  const bool refused =
      std::ranges::any_of(channels, [&](const KnownChannel& one) { return TotalsOf(counters, one).refused > 0; });
  Records records(robot.surroundings().console, options_.style,
                  {{"channel", "CHANNEL"},
                   {"type", "TYPE"},
                   {"publishers", "PUB", true},
                   {"subscribers", "SUB", true},
                   {"rate_hz", "RATE", true},
                   {"latched", "LATCHED", true},
                   {"refused", refused ? "REFUSED" : "", true},
                   {"via", "VIA"}});
  for (const KnownChannel& channel : channels) {
    const ChannelTotals totals = TotalsOf(counters, channel);
    records.Add({channel.name, channel.type_name, channel.publishers.size() + totals.far_publishers,
                 channel.subscribers.size() + totals.far_subscribers, RateOf(totals, options_.style),
                 totals.latched == 0 ? Cell(totals.latched, "-") : Cell(totals.latched),
                 totals.refused == 0 ? Cell(totals.refused, "-") : Cell(totals.refused).In(Style::kYellow),
                 TransportsOf(counters, channel)});
  }
  End(records, robot);
}

void List::ListSessions(Robot& robot) const {
  (void)robot.Counters();  // Afterwards it is known how each session is reached.
  struct Row {
    ChannelUser user;
    std::uint64_t publishes = 0;
    std::uint64_t subscribes = 0;
  };
  std::map<SessionId, Row> rows;
  for (const KnownChannel& channel : robot.Channels(true)) {
    const bool counts = all_ || !IsInternal(channel.name);
    for (const ChannelUser& user : channel.publishers) {
      Row& row = rows[user.session];
      row.user = user;
      row.publishes += counts ? 1 : 0;
    }
    for (const ChannelUser& user : channel.subscribers) {
      Row& row = rows[user.session];
      row.user = user;
      row.subscribes += counts ? 1 : 0;
    }
  }
  const std::vector<PeerInfo> peers = robot.session().Peers();
  Records records(robot.surroundings().console, options_.style,
                  {{"", "SESSION"},
                   {"process", ""},
                   {"pid", ""},
                   {"host", "HOST"},
                   {"session", ""},
                   {"publishes", "PUBLISHES", true},
                   {"subscribes", "SUBSCRIBES", true},
                   {"reached_by", "REACHED BY"}});
  std::vector<Row> sorted;
  for (auto& [id, row] : rows) sorted.push_back(std::move(row));
  std::ranges::stable_sort(sorted, {}, [](const Row& row) { return std::pair(row.user.host, row.user.process); });
  for (const Row& row : sorted) {
    const auto peer = std::ranges::find(peers, row.user.session, &PeerInfo::id);
    records.Add(UserCells(row.user, false) +
                std::vector<Cell>{row.publishes, row.subscribes, peer == peers.end() ? Cell() : Cell(peer->transport)});
  }
  End(records, robot);
}

void List::ListNodes(Robot& robot) const {
  Records records(robot.surroundings().console, options_.style,
                  std::vector<Column>{{"node", "NODE"}, {"channel", "CHANNEL"}} + UserColumns("PROCESS") +
                      std::vector<Column>{{"received", "RECEIVED", true},
                                          {"dropped", "DROPPED", true},
                                          {"failed", "FAILED", true},
                                          {"run_p50_ns", "RUN P50", true},
                                          {"wait_p99_ns", "WAIT P99", true}});
  const auto duration = [this](std::int64_t ns) {
    return Cell(ns, ns == 0 ? "-" : DurationText(ns, options_.style.exact));
  };
  const auto fault = [](std::uint64_t count) { return count == 0 ? Cell(count, "-") : Cell(count).In(Style::kYellow); };
  for (const auto& [id, snapshot] : robot.Counters()) {
    ChannelUser who = UserOf(*snapshot);
    who.session = id;  // The sender's; what it says of itself may be wrong.
    const std::vector<Cell> user = UserCells(who, false);
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      if (!all_ && IsInternal(channel.name())) continue;
      for (const Snapshot::Node& node : channel.nodes()) {
        records.Add(std::vector<Cell>{node.name(), channel.name()} + user +
                    std::vector<Cell>{std::uint64_t{node.received()}, fault(node.dropped()), fault(node.failed()),
                                      duration(node.run_p50_ns()), duration(node.wait_p99_ns())});
      }
    }
  }
  End(records, robot);
}

void List::ListServices(Robot& robot) const {
  Records records(
      robot.surroundings().console, options_.style,
      {{"service", "SERVICE"}, {"request_type", "REQUEST"}, {"servers", "SERVED BY"}, {"callers", "CALLED BY"}});
  for (const KnownChannel& channel : robot.Channels(true)) {
    const std::string_view service = ServiceOf(channel.name);
    if (service.empty()) continue;
    records.Add(
        {std::string(service), channel.type_name, UserListCell(channel.subscribers), UserListCell(channel.publishers)});
  }
  End(records, robot);
}

int List::Run(Surroundings& surroundings) {
  Robot robot(options_, surroundings);
  if (what_ == "channels") ListChannels(robot);
  if (what_ == "sessions") ListSessions(robot);
  if (what_ == "nodes") ListNodes(robot);
  if (what_ == "services") ListServices(robot);
  if (what_ == "params") return WriteParams(robot, options_, ParamSessions(robot));
  if (what_ == "frames") WriteFrames(robot, options_);
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeList() { return std::make_unique<List>(); }

}  // namespace hgros::cli
