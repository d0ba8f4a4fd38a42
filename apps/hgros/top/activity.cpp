#include "top/activity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "robot/channel_rates.hpp"
#include "robot/descriptions.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {
namespace {

constexpr int kMostSilent = 3;

double SecondsBetween(const Snapshot* before, const Snapshot& now) {
  return before == nullptr ? 0 : static_cast<double>(now.steady_ns() - before->steady_ns()) / 1e9;
}

// The sum of two numbers of which each may be unknown.
void AddTo(std::optional<double>& sum, std::optional<double> one) {
  if (one) sum = sum.value_or(0) + *one;
}

// Differences of counts per second. Unknown: there is no snapshot before, or it began again.
class PerSecond {
 public:
  explicit PerSecond(double seconds) : seconds_(seconds) {}
  [[nodiscard]] std::optional<double> operator()(std::uint64_t before, std::uint64_t now) const {
    if (seconds_ <= 0 || now < before) return std::nullopt;
    return static_cast<double>(now - before) / seconds_;
  }

 private:
  const double seconds_;
};

std::uint64_t DroppedBy(const Snapshot::Channel& channel) {
  std::uint64_t dropped = channel.refused() + channel.send_dropped() + channel.lost();
  for (const Snapshot::Node& node : channel.nodes()) dropped += node.dropped();
  return dropped;
}

}  // namespace

const std::vector<Column>& TopColumns(TopKind kind) {
  static const std::vector<Column> sessions =
      UserColumns("SESSION") +
      std::vector<Column>{{"cpu_percent", "CPU", true, 7},  {"memory_bytes", "MEMORY", true, 7},
                          {"run_percent", "RUN", true, 7},  {"wait_p99_ns", "WAIT P99", true, 8},
                          {"drops_hz", "DROPS/S", true, 7}, {"published_hz", "OUT", true, 8},
                          {"received_hz", "IN", true, 8},   {"dropped", "DROPPED", true, 7},
                          {"channels", "CHANNELS", true},   {"nodes", "NODES", true}};
  static const std::vector<Column> nodes =
      std::vector<Column>{{"node", "NODE"}, {"channel", "CHANNEL"}} + UserColumns("SESSION") +
      std::vector<Column>{{"run_percent", "RUN", true, 7},      {"rate_hz", "RATE", true, 8},
                          {"wait_p99_ns", "WAIT P99", true, 8}, {"drops_hz", "DROPS/S", true, 7},
                          {"queued", "QUEUE", true, 5},         {"dropped", "DROPPED", true, 7},
                          {"run_p50_ns", "RUN P50", true, 7},   {"run_p99_ns", "RUN P99", true, 7},
                          {"wait_p50_ns", "WAIT P50", true, 8}, {"failed", "FAILED", true}};
  static const std::vector<Column> channels{{"channel", "CHANNEL"},
                                            {"rate_hz", "RATE", true, 8},
                                            {"bytes_per_second", "BANDWIDTH", true, 9},
                                            {"mean_bytes", "SIZE", true, 7},
                                            {"publishers", "PUB", true},
                                            {"subscribers", "SUB", true},
                                            {"drops_hz", "DROPS/S", true, 7},
                                            {"type", "TYPE"},
                                            {"dropped", "DROPPED", true, 7},
                                            {"via", "VIA"}};
  return kind == TopKind::kSessions ? sessions : kind == TopKind::kNodes ? nodes : channels;
}

std::size_t FirstSortOf(TopKind kind) {
  const char* key = kind == TopKind::kSessions ? "cpu_percent" : kind == TopKind::kNodes ? "run_percent" : "rate_hz";
  const std::vector<Column>& columns = TopColumns(kind);
  return static_cast<std::size_t>(std::ranges::find(columns, key, &Column::key) - columns.begin());
}

// Over all sessions that use the channel.
struct Activity::ChannelSum {
  std::optional<double> rate_hz;
  std::optional<double> drops_hz;
  std::uint64_t dropped = 0;
  std::uint64_t encoded = 0;  // In the last interval, or if there were none, since the sessions began.
  std::uint64_t bytes = 0;
  bool silent = true;
};

struct Activity::SessionSum {
  std::optional<double> published_hz;
  std::optional<double> received_hz;
  std::optional<double> drops_hz;
  std::optional<double> run_percent;
  std::uint64_t dropped = 0;
  std::uint64_t nodes = 0;
  std::uint64_t channels = 0;
  std::int64_t wait_p99_ns = 0;
};

Cell Activity::Rate(std::optional<double> hertz) const {
  if (!hertz) return {};
  return {*hertz, *hertz == 0 ? "-" : RateText(*hertz, style_.exact)};
}

Cell Activity::Percent(std::optional<double> percent) const {
  if (!percent) return {};
  return {*percent, style_.exact ? fmt::format("{:.6f}", *percent) : fmt::format("{:.1f} %", *percent)};
}

Cell Activity::Time(std::int64_t ns) const { return {ns, ns == 0 ? "-" : DurationText(ns, style_.exact)}; }

Cell Activity::Drops(std::optional<double> per_second) const {
  if (!per_second) return {};
  if (*per_second == 0) return {0.0, "-"};
  return Cell(*per_second, fmt::format("{:.{}f}", *per_second,
                                       style_.exact       ? 6
                                       : *per_second < 10 ? 1
                                                          : 0))
      .In(Style::kYellow);
}

void Activity::Take(const AllCounters& counters) {
  std::erase_if(known_, [&](const auto& one) { return !counters.contains(one.first); });
  for (const auto& [session, snapshot] : counters) {
    Known& known = known_[session];
    if (known.now == nullptr || snapshot->steady_ns() > known.now->steady_ns()) {
      known.before = std::exchange(known.now, snapshot);
      known.unchanged = 0;
    } else {
      ++known.unchanged;
    }
  }
}

void Activity::AddNodes(const std::vector<Cell>& session, const Known& known, const Snapshot::Channel& channel,
                        const Snapshot::Channel* before, SessionSum& sum) {
  const bool silent = known.unchanged > kMostSilent;
  const PerSecond per_second(SecondsBetween(known.before.get(), *known.now));
  std::map<std::string_view, std::size_t> seen;
  for (const Snapshot::Node& node : channel.nodes()) {
    TopRow row;
    row.kind = TopKind::kNodes;
    row.session = SessionId{known.now->session()};
    row.channel = channel.name();
    row.node = node.name();
    row.same_named = seen[node.name()]++;
    row.silent = silent;
    row.id = row.session.ToString() + '\0' + row.channel + '\0' + row.node + '\0' + std::to_string(row.same_named);
    std::optional<double> run;
    std::optional<double> rate;
    std::optional<double> drops;
    const Snapshot::Node* old = FindNode(before, node.name(), row.same_named);
    if (old != nullptr && !silent) {
      rate = per_second(old->run(), node.run());
      drops = per_second(old->dropped(), node.dropped());
      run = per_second(old->run_sum_ns(), node.run_sum_ns());
      if (run) run = *run / 1e9 * 100;
    }
    AddTo(sum.run_percent, run);
    sum.wait_p99_ns = std::max<std::int64_t>(sum.wait_p99_ns, node.wait_p99_ns());
    ++sum.nodes;
    const auto fault = [](std::uint64_t count) {
      return count == 0 ? Cell(count, "-") : Cell(count).In(Style::kYellow);
    };
    row.cells = std::vector<Cell>{node.name(), channel.name()} + session +
                std::vector<Cell>{Percent(run),
                                  Rate(rate),
                                  Time(node.wait_p99_ns()),
                                  Drops(drops),
                                  node.queued() == 0 ? Cell(std::uint64_t{0}, "-") : Cell(std::uint64_t{node.queued()}),
                                  fault(node.dropped()),
                                  Time(node.run_p50_ns()),
                                  Time(node.run_p99_ns()),
                                  Time(node.wait_p50_ns()),
                                  fault(node.failed())};
    rows_[static_cast<std::size_t>(TopKind::kNodes)].push_back(std::move(row));
  }
}

void Activity::AddSession(const ChannelUser& user, std::map<std::string_view, ChannelSum>& sums, bool several_hosts) {
  TopRow row;
  row.id = user.session.ToString();
  row.session = user.session;
  row.cells = UserCells(user, several_hosts);
  const std::vector<Cell> name = row.cells;
  row.silent = true;
  if (const auto found = known_.find(user.session); found != known_.end()) {
    const Known& known = found->second;
    const Snapshot& now = *known.now;
    const Snapshot* before = known.before.get();
    row.silent = known.unchanged > kMostSilent;
    const double seconds = SecondsBetween(before, now);
    const PerSecond per_second(row.silent ? 0 : seconds);
    SessionSum sum;
    for (const Snapshot::Channel& channel : now.channels()) {
      if (!all_ && IsInternal(channel.name())) continue;
      const Snapshot::Channel* old = CountersIn(before, channel.name());
      AddNodes(name, known, channel, old, sum);
      ++sum.channels;
      ChannelSum& on_channel = sums[channel.name()];
      const std::uint64_t dropped = DroppedBy(channel);
      sum.dropped += dropped;
      on_channel.dropped += dropped;
      if (row.silent) continue;
      on_channel.silent = false;
      // At first, the publisher's own rate.
      std::optional<double> published = channel.rate_hz();
      std::uint64_t encoded = 0;
      std::uint64_t bytes = 0;
      if (old != nullptr) {
        published.reset();
        if (channel.published() >= old->published()) {
          published = PublishedRate(channel.rate_hz(), channel.published() - old->published(), seconds);
        }
        const std::optional<double> drops = per_second(DroppedBy(*old), dropped);
        AddTo(sum.received_hz, per_second(old->received(), channel.received()));
        AddTo(sum.drops_hz, drops);
        AddTo(on_channel.drops_hz, drops);
        encoded = channel.encoded() - std::min(old->encoded(), channel.encoded());
        bytes = channel.encoded_bytes() - std::min(old->encoded_bytes(), channel.encoded_bytes());
      }
      AddTo(sum.published_hz, published);
      AddTo(on_channel.rate_hz, published);
      on_channel.encoded += encoded > 0 ? encoded : channel.encoded();
      on_channel.bytes += encoded > 0 ? bytes : channel.encoded_bytes();
    }
    std::optional<double> cpu;
    if (before != nullptr && now.cpu_ns() >= before->cpu_ns()) {
      cpu = per_second(static_cast<std::uint64_t>(before->cpu_ns()), static_cast<std::uint64_t>(now.cpu_ns()));
      if (cpu) cpu = *cpu / 1e9 * 100;
    }
    const auto memory = static_cast<double>(now.memory_bytes());
    for (Cell& cell :
         std::vector<Cell>{Percent(cpu), Cell(memory, BytesText(memory, style_.exact)), Percent(sum.run_percent),
                           Time(sum.wait_p99_ns), Drops(sum.drops_hz), Rate(sum.published_hz), Rate(sum.received_hz),
                           sum.dropped == 0 ? Cell(sum.dropped, "-") : Cell(sum.dropped), sum.channels, sum.nodes}) {
      row.cells.push_back(std::move(cell));
    }
  }
  row.cells.resize(TopColumns(TopKind::kSessions).size());
  rows_[static_cast<std::size_t>(TopKind::kSessions)].push_back(std::move(row));
}

void Activity::AddChannel(const KnownChannel& channel, const ChannelSum& sum, const AllCounters& counters) {
  TopRow row;
  row.kind = TopKind::kChannels;
  row.id = channel.name;
  row.channel = channel.name;
  row.silent = sum.silent;
  Cell size;
  Cell bandwidth;
  if (sum.encoded > 0) {
    const double mean = static_cast<double>(sum.bytes) / static_cast<double>(sum.encoded);
    size = Cell(mean, BytesText(style_.exact ? mean : std::round(mean), style_.exact));
    const double bytes = mean * sum.rate_hz.value_or(0);
    bandwidth = Cell(bytes, bytes == 0 ? "-" : BandwidthText(bytes, style_.exact));
  }
  row.cells = {channel.name,
               Rate(sum.rate_hz),
               std::move(bandwidth),
               std::move(size),
               std::uint64_t{channel.publishers.size()},
               channel.subscribers.size() + TotalsOf(counters, channel).far_subscribers,
               Drops(sum.drops_hz),
               channel.type_name,
               sum.dropped == 0 ? Cell(sum.dropped, "-") : Cell(sum.dropped).In(Style::kYellow),
               TransportsOf(counters, channel)};
  rows_[static_cast<std::size_t>(TopKind::kChannels)].push_back(std::move(row));
}

void Activity::Update(const AllCounters& counters, const std::vector<KnownChannel>& channels) {
  Take(counters);
  for (std::vector<TopRow>& rows : rows_) rows.clear();
  const std::map<SessionId, ChannelUser> sessions = SessionsOf(channels);
  std::map<std::string_view, ChannelSum> sums;
  const bool several_hosts = AreOnSeveralHosts(sessions);
  for (const auto& [id, user] : sessions) AddSession(user, sums, several_hosts);
  for (const KnownChannel& channel : channels) {
    if (all_ || !IsInternal(channel.name)) AddChannel(channel, sums[channel.name], counters);
  }
  for (std::vector<TopRow>& rows : rows_) {
    std::ranges::stable_sort(rows, {}, [](const TopRow& row) -> const std::string& {
      return std::get<std::string>(row.cells.front().value());
    });
  }
}

}  // namespace hgros::cli
