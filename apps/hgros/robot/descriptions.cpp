#include "robot/descriptions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hgros/base/cause.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

// Cells of the numbers that several tables have.
class Cells {
 public:
  explicit Cells(const KnownRobot& robot) : exact_(robot.style.exact) {
    several_hosts_ = AreOnSeveralHosts(SessionsOf(robot.channels));
  }

  [[nodiscard]] Cell Rate(double hertz) const { return {hertz, hertz == 0 ? "-" : RateText(hertz, exact_)}; }
  [[nodiscard]] Cell Time(std::int64_t ns) const { return {ns, ns == 0 ? "-" : DurationText(ns, exact_)}; }
  [[nodiscard]] Cell Bytes(double bytes) const { return {bytes, BytesText(bytes, exact_)}; }
  [[nodiscard]] Cell Bandwidth(double bytes) const { return {bytes, BandwidthText(bytes, exact_)}; }
  [[nodiscard]] static Cell Fault(std::uint64_t count) {
    return count == 0 ? Cell(count, "-") : Cell(count).In(Style::kYellow);
  }
  [[nodiscard]] Cell Mean(const Snapshot::Channel& counts) const {
    if (counts.encoded() == 0) return {};
    return Bytes(static_cast<double>(counts.encoded_bytes()) / static_cast<double>(counts.encoded()));
  }

  static Cell Count(std::uint64_t count) { return count == 0 ? Cell(count, "-") : Cell(count); }
  static Cell Closed(const Snapshot::Channel& counts) { return counts.closed() ? Cell(true) : Cell(false, "-"); }

  [[nodiscard]] std::vector<Cell> User(const ChannelUser& user) const { return UserCells(user, several_hosts_); }

 private:
  const bool exact_;
  bool several_hosts_ = false;
};

std::string FingerprintText(std::uint64_t fingerprint) {
  return fingerprint == 0 ? "" : fmt::format("{:016x}", fingerprint);
}

// The user's type. People see it only if it is not the channel's.
std::vector<Column> TypeColumns() { return {{"type", ""}, {"", "OTHER TYPE"}, {"fingerprint", ""}}; }

std::vector<Cell> TypeCells(const KnownChannel& channel, const ChannelUser& user) {
  const bool other_name = user.type_name != channel.type_name;
  const bool differs =
      !user.type_name.empty() &&
      (other_name || (user.fingerprint != 0 && channel.fingerprint != 0 && user.fingerprint != channel.fingerprint));
  const std::string fingerprint = FingerprintText(user.fingerprint);
  return {user.type_name,
          !differs ? Cell() : Cell(other_name ? user.type_name : user.type_name + " " + fingerprint).In(Style::kYellow),
          fingerprint};
}

std::string QueueText(const Snapshot::Node& node) {
  return fmt::format("{} {}", node.lossless() ? "lossless" : "keep last", node.queue_depth());
}

const std::vector<Column>& NodeColumns() {
  static const std::vector<Column> columns{{"node", "NODE"},
                                           {"channel", ""},
                                           {"serial", ""},
                                           {"lossless", ""},
                                           {"queue_depth", ""},
                                           {"", "QUEUE"},
                                           {"queued", "WAITING", true},
                                           {"executor", "EXECUTOR"},
                                           {"received", "RECEIVED", true},
                                           {"dropped", "DROPPED", true},
                                           {"run", ""},
                                           {"failed", "FAILED", true},
                                           {"refused", "REFUSED", true},
                                           {"wait_p50_ns", ""},
                                           {"wait_p99_ns", "WAIT P99", true},
                                           {"run_p50_ns", "RUN P50", true},
                                           {"run_p99_ns", ""},
                                           {"run_sum_ns", ""}};
  return columns;
}

std::vector<Cell> NodeRow(const Cells& cells, const std::string& channel, const Snapshot::Node& node) {
  return {node.name(),
          channel,
          node.serial(),
          node.lossless(),
          std::uint64_t{node.queue_depth()},
          QueueText(node),
          Cells::Count(node.queued()),
          node.executor(),
          std::uint64_t{node.received()},
          Cells::Fault(node.dropped()),
          std::uint64_t{node.run()},
          Cells::Fault(node.failed()),
          Cells::Fault(node.refused()),
          cells.Time(node.wait_p50_ns()),
          cells.Time(node.wait_p99_ns()),
          cells.Time(node.run_p50_ns()),
          cells.Time(node.run_p99_ns()),
          std::uint64_t{node.run_sum_ns()}};
}

// The nodes of a channel in all sessions that receive it.
Sheet::Table NodesOf(const KnownRobot& robot, const Cells& cells, const KnownChannel& channel) {
  Sheet::Table table{"nodes", UserColumns("IN") + NodeColumns(), {}};
  std::rotate(table.columns.begin(), table.columns.begin() + 5, table.columns.begin() + 6);
  for (const ChannelUser& user : channel.subscribers) {
    const Snapshot::Channel* counts = CountersOf(robot.counters, user.session, channel.name);
    if (counts == nullptr) continue;
    for (const Snapshot::Node& node : counts->nodes()) {
      std::vector<Cell>& row = table.rows.emplace_back(cells.User(user) + NodeRow(cells, channel.name, node));
      std::rotate(row.begin(), row.begin() + 5, row.begin() + 6);
    }
  }
  return table;
}

// A table of the users of a channel. `row` makes the cells behind those that say who it is and with which type; the
// counts are null if they are not known.
template <class Row>
void AddUsers(Sheet& sheet, const KnownRobot& robot, const Cells& cells, const KnownChannel& channel,
              Sheet::Table table, const std::vector<ChannelUser>& users, const Row& row) {
  for (const ChannelUser& user : users) {
    table.rows.push_back(cells.User(user) + TypeCells(channel, user) +
                         row(user, CountersOf(robot.counters, user.session, channel.name)));
  }
  sheet.Add(std::move(table));
}

void AddPublishers(Sheet& sheet, const KnownRobot& robot, const Cells& cells, const KnownChannel& channel) {
  const std::vector<Column> counted{{"rate_hz", "RATE", true},         {"published", "PUBLISHED", true},
                                    {"refused", "REFUSED", true},      {"sent", "SENT", true},
                                    {"send_dropped", "DROPPED", true}, {"mean_bytes", "MEAN SIZE", true},
                                    {"latched", "LATCHED", true},      {"closed", "CLOSED"}};
  AddUsers(sheet, robot, cells, channel, {"publishers", UserColumns("PUBLISHER") + TypeColumns() + counted, {}},
           channel.publishers, [&](const ChannelUser&, const Snapshot::Channel* counts) -> std::vector<Cell> {
             if (counts == nullptr) return {};
             return {cells.Rate(counts->rate_hz()),        std::uint64_t{counts->published()},
                     Cells::Fault(counts->refused()),      Cells::Count(counts->sent()),
                     Cells::Fault(counts->send_dropped()), cells.Mean(*counts),
                     Cells::Count(counts->latched()),      Cells::Closed(*counts)};
           });
}

void AddSubscribers(Sheet& sheet, const KnownRobot& robot, const Cells& cells, const KnownChannel& channel) {
  const std::vector<Column> counted{{"lossless", "LOSSLESS"},
                                    {"received", "RECEIVED", true},
                                    {"lost", "LOST", true},
                                    {"faults", "FAULTS", true},
                                    {"transport_p50_ns", "TRANSPORT P50", true},
                                    {"transport_p99_ns", "P99", true},
                                    {"closed", "CLOSED"}};
  AddUsers(sheet, robot, cells, channel, {"subscribers", UserColumns("SUBSCRIBER") + TypeColumns() + counted, {}},
           channel.subscribers, [&](const ChannelUser& user, const Snapshot::Channel* counts) -> std::vector<Cell> {
             if (counts == nullptr) return {user.lossless};
             return {user.lossless,
                     std::uint64_t{counts->received()},
                     Cells::Fault(counts->lost()),
                     Cells::Fault(counts->faults()),
                     cells.Time(counts->transport_p50_ns()),
                     cells.Time(counts->transport_p99_ns()),
                     Cells::Closed(*counts)};
           });
}

void AddPairs(Sheet& sheet, const KnownRobot& robot, const KnownChannel& channel) {
  Sheet::Table table{"pairs", {{"from", "FROM"}, {"to", "TO"}, {"via", "VIA"}, {"why", "WHY"}}, {}};
  for (const ChannelUser& from : channel.publishers) {
    for (const ChannelUser& to : channel.subscribers) {
      const Way way = WayBetween(robot.counters, from.session, to.session);
      table.rows.push_back({UserCell(from), UserCell(to), way.transport, way.why});
    }
  }
  sheet.Add(std::move(table));
}

const char* EncodingText(Encoding encoding) {
  switch (encoding) {
    case Encoding::kProtobuf: return "protobuf";
    case Encoding::kCustom: return "custom";
    case Encoding::kPlain: return "plain";
    case Encoding::kNone: break;
  }
  return "";
}

// How old data was when the node handled it. Packets name channels by their hash.
Sheet::Table AgesOf(const KnownRobot& robot, const Cells& cells, const Snapshot::Node& node) {
  std::map<std::uint32_t, std::string> names;
  for (const auto& [id, snapshot] : robot.counters) {
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      names.emplace(Cause::OriginOf(channel.name()), channel.name());
    }
  }
  Sheet::Table table{"ages",
                     {{"origin", "DATA SINCE"},
                      {"messages", "MESSAGES", true},
                      {"age_p50_ns", "AGE P50", true},
                      {"age_p99_ns", "P99", true},
                      {"age_max_ns", "MAX", true}},
                     {}};
  for (const Snapshot::ChainAge& ages : node.ages()) {
    const auto name = names.find(ages.origin());
    table.rows.push_back({ages.origin() == 0    ? Cell("others")
                          : name != names.end() ? Cell(name->second)
                                                : Cell(fmt::format("channel {:08x}", ages.origin())),
                          std::uint64_t{ages.count()}, cells.Time(ages.p50_ns()), cells.Time(ages.p99_ns()),
                          cells.Time(ages.max_ns())});
  }
  return table;
}

}  // namespace

std::map<SessionId, ChannelUser> SessionsOf(const std::vector<KnownChannel>& channels) {
  std::map<SessionId, ChannelUser> sessions;
  for (const KnownChannel& channel : channels) {
    for (const ChannelUser& user : channel.publishers) sessions[user.session] = user;
    for (const ChannelUser& user : channel.subscribers) sessions[user.session] = user;
  }
  return sessions;
}

bool AreOnSeveralHosts(const std::map<SessionId, ChannelUser>& sessions) {
  return std::ranges::any_of(sessions,
                             [&](const auto& one) { return one.second.host != sessions.begin()->second.host; });
}

Sheet DescribeChannel(const KnownRobot& robot, const KnownChannel& channel) {
  const Cells cells(robot);
  Sheet sheet("channel", channel.name);
  const ChannelTotals totals = TotalsOf(robot.counters, channel);
  sheet.Fact("type", "Type", channel.type_name);
  sheet.Fact("encoding", "Encoding", EncodingText(channel.encoding));
  sheet.Fact("fingerprint", "Fingerprint", FingerprintText(channel.fingerprint));
  sheet.Fact("rate_hz", "Rate", totals.known ? cells.Rate(totals.rate_hz) : Cell());
  sheet.Fact("published", "Published", totals.known ? Cell(totals.published) : Cell());
  const bool sized = totals.encoded > 0;
  const double mean = sized ? static_cast<double>(totals.encoded_bytes) / static_cast<double>(totals.encoded) : 0;
  sheet.Fact("mean_bytes", "Mean size", sized ? cells.Bytes(mean) : Cell());
  sheet.Fact("bytes_per_second", "Bandwidth", sized ? cells.Bandwidth(mean * totals.rate_hz) : Cell());
  sheet.Fact("latched", "Latched", totals.known ? Cells::Count(totals.latched) : Cell());
  AddPublishers(sheet, robot, cells, channel);
  AddSubscribers(sheet, robot, cells, channel);
  sheet.Add(NodesOf(robot, cells, channel));
  AddPairs(sheet, robot, channel);
  return sheet;
}

Sheet DescribeSession(const KnownRobot& robot, const ChannelUser& session) {
  const Cells cells(robot);
  Sheet sheet("session", session.process);
  sheet.Fact("session", "Id", session.session.ToString());
  sheet.Fact("pid", "Process id", session.pid);
  sheet.Fact("host", "Host", session.host);
  const auto found = robot.counters.find(session.session);
  if (found == robot.counters.end()) return sheet;
  const Snapshot& counts = *found->second;
  sheet.Fact("version", "Version", counts.version());
  sheet.Fact("cpu_ns", "CPU time", cells.Time(counts.cpu_ns()));
  sheet.Fact("memory_bytes", "Memory", cells.Bytes(static_cast<double>(counts.memory_bytes())));
  Sheet::Table publishes{"publishes",
                         {{"channel", "PUBLISHES"},
                          {"type", "TYPE"},
                          {"rate_hz", "RATE", true},
                          {"published", "PUBLISHED", true},
                          {"refused", "REFUSED", true},
                          {"sent", "SENT", true},
                          {"send_dropped", "DROPPED", true},
                          {"mean_bytes", "MEAN SIZE", true},
                          {"latched", "LATCHED", true},
                          {"closed", "CLOSED"}},
                         {}};
  Sheet::Table receives{"receives",
                        {{"channel", "RECEIVES"},
                         {"type", "TYPE"},
                         {"received", "RECEIVED", true},
                         {"lost", "LOST", true},
                         {"faults", "FAULTS", true},
                         {"transport_p50_ns", "TRANSPORT P50", true},
                         {"transport_p99_ns", "P99", true}},
                        {}};
  Sheet::Table nodes{"nodes", NodeColumns(), {}};
  nodes.columns[1].heading = "CHANNEL";
  for (const Snapshot::Channel& channel : counts.channels()) {
    if (channel.name().starts_with("hgros/")) continue;
    if (channel.published() > 0 || channel.latched() > 0) {
      publishes.rows.push_back({channel.name(), channel.type(), cells.Rate(channel.rate_hz()),
                                std::uint64_t{channel.published()}, Cells::Fault(channel.refused()),
                                Cells::Count(channel.sent()), Cells::Fault(channel.send_dropped()), cells.Mean(channel),
                                Cells::Count(channel.latched()), Cells::Closed(channel)});
    }
    if (channel.received() + channel.lost() + channel.faults() > 0) {
      receives.rows.push_back({channel.name(), channel.type(), std::uint64_t{channel.received()},
                               Cells::Fault(channel.lost()), Cells::Fault(channel.faults()),
                               cells.Time(channel.transport_p50_ns()), cells.Time(channel.transport_p99_ns())});
    }
    for (const Snapshot::Node& node : channel.nodes()) nodes.rows.push_back(NodeRow(cells, channel.name(), node));
  }
  Sheet::Table services{"services",
                        {{"service", "SERVES"},
                         {"unhandled_requests", "UNHANDLED REQUESTS", true},
                         {"dropped_replies", "DROPPED REPLIES", true}},
                        {}};
  for (const Snapshot::Service& service : counts.services()) {
    services.rows.push_back(
        {service.name(), Cells::Fault(service.unhandled_requests()), Cells::Fault(service.dropped_replies())});
  }
  Sheet::Table peers{"peers", UserColumns("PEER") + std::vector<Column>{{"via", "VIA"}, {"why", "WHY"}}, {}};
  const std::map<SessionId, ChannelUser> sessions = SessionsOf(robot.channels);
  for (const Snapshot::Peer& peer : counts.peers()) {
    const auto known = sessions.find(SessionId{peer.session()});
    if (known == sessions.end()) continue;  // Such as the session of this command.
    peers.rows.push_back(UserCells(known->second, true) + std::vector<Cell>{peer.transport(), peer.why()});
  }
  for (Sheet::Table* table : {&publishes, &receives, &nodes, &services, &peers}) sheet.Add(std::move(*table));
  return sheet;
}

Sheet DescribeNode(const KnownRobot& robot, SessionId session, const Snapshot::Channel& channel,
                   const Snapshot::Node& node) {
  const Cells cells(robot);
  const Snapshot& snapshot = *robot.counters.at(session);
  Sheet sheet("node", node.name());
  sheet.Fact("channel", "Channel", channel.name());
  sheet.Fact("type", "Type", channel.type());
  sheet.Fact("process", "Process", Cell(snapshot.process()));
  sheet.Fact("pid", "Process id", Cell(std::int64_t{snapshot.pid()}));
  sheet.Fact("host", "Host", snapshot.host());
  sheet.Fact("session", "Session", session.ToString());
  sheet.Fact("serial", "Serial", node.serial());
  sheet.Fact("lossless", "Lossless", node.lossless());
  sheet.Fact("queue_depth", "Queue", Cell(std::uint64_t{node.queue_depth()}, QueueText(node)));
  sheet.Fact("queued", "Waiting now", std::uint64_t{node.queued()});
  sheet.Fact("executor", "Executor", node.executor());
  sheet.Fact("received", "Received", std::uint64_t{node.received()});
  sheet.Fact("dropped", "Dropped", node.dropped() == 0 ? Cell(std::uint64_t{0}) : Cells::Fault(node.dropped()));
  sheet.Fact("run", "Run", std::uint64_t{node.run()});
  sheet.Fact("failed", "Failed", node.failed() == 0 ? Cell(std::uint64_t{0}) : Cells::Fault(node.failed()));
  sheet.Fact("refused", "Refused", node.refused() == 0 ? Cell(std::uint64_t{0}) : Cells::Fault(node.refused()));
  sheet.Fact("wait_p50_ns", "Wait p50", cells.Time(node.wait_p50_ns()));
  sheet.Fact("wait_p99_ns", "Wait p99", cells.Time(node.wait_p99_ns()));
  sheet.Fact("run_p50_ns", "Run p50", cells.Time(node.run_p50_ns()));
  sheet.Fact("run_p99_ns", "Run p99", cells.Time(node.run_p99_ns()));
  sheet.Fact("run_sum_ns", "Run in all", cells.Time(static_cast<std::int64_t>(node.run_sum_ns())));
  sheet.Add(AgesOf(robot, cells, node));
  return sheet;
}

Sheet DescribeService(const KnownRobot& robot, const KnownChannel& channel) {
  const Cells cells(robot);
  const std::string name(ServiceOf(channel.name));
  Sheet sheet("service", name);
  sheet.Fact("request_type", "Request", channel.type_name);
  Sheet::Table servers{
      "servers",
      UserColumns("SERVED BY") + std::vector<Column>{{"unhandled_requests", "UNHANDLED REQUESTS", true},
                                                     {"dropped_replies", "DROPPED REPLIES", true}},
      {}};
  for (const ChannelUser& user : channel.subscribers) {
    std::vector<Cell> row = cells.User(user);
    std::vector<Cell> counts(2);
    if (const auto found = robot.counters.find(user.session); found != robot.counters.end()) {
      for (const Snapshot::Service& one : found->second->services()) {
        if (one.name() == name) {
          counts = {Cells::Fault(one.unhandled_requests()), Cells::Fault(one.dropped_replies())};
        }
      }
    }
    servers.rows.push_back(std::move(row) + std::move(counts));
  }
  Sheet::Table callers{"callers", UserColumns("CALLED BY"), {}};
  for (const ChannelUser& user : channel.publishers) callers.rows.push_back(cells.User(user));
  sheet.Add(std::move(servers));
  sheet.Add(std::move(callers));
  sheet.Add(NodesOf(robot, cells, channel));
  return sheet;
}

}  // namespace hgros::cli
