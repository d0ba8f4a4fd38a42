#include "viewer/data/channels/hypergraph.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

using Counts = Hypergraph::Counts;

/// A process is identified by its session; one of its nodes by session, channel and name.
using Vertex = std::tuple<std::uint64_t, std::string, std::string>;

bool Disagrees(const KnownChannel& channel, const ChannelUser& user) {
  return !user.type_name.empty() &&
         (user.type_name != channel.type_name ||
          (user.fingerprint != 0 && channel.fingerprint != 0 && user.fingerprint != channel.fingerprint));
}

Counts OfPublisher(const SessionCounts::Use& use) {
  Counts counts;
  counts.messages = use.published.messages;
  counts.per_second = use.published.per_second;
  counts.refused = use.refused;
  counts.dropped = use.send_dropped;
  return counts;
}

Counts OfNode(const SessionCounts::Node& node, const SessionCounts::Use& use) {
  Counts counts;
  counts.lost = use.lost;
  counts.unreadable = use.faults;
  counts.messages = node.received.messages;
  counts.per_second = node.received.per_second;
  counts.dropped = node.dropped;
  counts.failed = node.failed;
  counts.run_p99_ns = node.run_p99_ns;
  return counts;
}

/// Messages of its busiest node, which also gets what its own process publishes.
Counts OfSubscriber(const SessionCounts::Use& use) {
  Counts counts;
  counts.messages = use.received.messages;
  counts.per_second = use.received.per_second;
  for (const SessionCounts::Node& node : use.nodes) {
    if (node.received.messages >= counts.messages) {
      counts.messages = node.received.messages;
      counts.per_second = node.received.per_second;
    }
    counts.dropped += node.dropped;
    counts.failed += node.failed;
    counts.run_p99_ns = std::max(counts.run_p99_ns, node.run_p99_ns);
  }
  counts.lost = use.lost;
  counts.unreadable = use.faults;
  return counts;
}

class Maker {
 public:
  Maker(SessionId own, const SessionCounts& counts, HypergraphDetail detail)
      : own_(own), counts_(counts), detail_(detail) {}

  void Add(const KnownChannel& channel) {
    if (!detail_.inner && channel.name.starts_with("hgros/")) return;
    const std::size_t place = graph_.channels.size();
    graph_.channels.push_back({channel.name, channel.type_name, false, {}});
    for (const ChannelUser& user : channel.publishers) AddPublisher(channel, user, place);
    for (const ChannelUser& user : channel.subscribers) AddSubscriber(channel, user, place);
    GuessRate(place);
  }

  // Until here, lines use indices of processes in the order of arrival.
  [[nodiscard]] Hypergraph Done() && {
    std::vector<std::size_t> order(graph_.processes.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](std::size_t i) {
      const Hypergraph::Process& process = graph_.processes[i];
      return std::tie(process.name, process.session.value, process.node);
    });
    std::vector<Hypergraph::Process> sorted;
    std::vector<std::size_t> places(order.size());
    for (const std::size_t i : order) {
      places[i] = sorted.size();
      sorted.push_back(std::move(graph_.processes[i]));
    }
    graph_.processes = std::move(sorted);
    for (Hypergraph::Line& line : graph_.lines) line.process = places[line.process];
    return std::move(graph_);
  }

 private:
  std::size_t PlaceOf(const ChannelUser& user, const std::string& channel, const std::string& node) {
    const auto [entry, added] = places_.try_emplace(
        Vertex{user.session.value, node.empty() ? std::string() : channel, node}, graph_.processes.size());
    if (added) {
      graph_.processes.push_back({user.session, std::string(CutText(user.process)), std::string(CutText(user.host)),
                                  user.pid, user.session == own_, node});
    }
    return entry->second;
  }

  void AddPublisher(const KnownChannel& channel, const ChannelUser& user, std::size_t place) {
    Hypergraph::Channel& added = graph_.channels[place];
    added.types_differ = added.types_differ || Disagrees(channel, user);
    Hypergraph::Line line{PlaceOf(user, channel.name, {}), place, true, false};
    if (const SessionCounts::Use* const use = counts_.Find(user.session.value, channel.name)) {
      line.counts = OfPublisher(*use);
      if (line.counts->per_second) added.per_second = added.per_second.value_or(0) + *line.counts->per_second;
    }
    graph_.lines.push_back(line);
  }

  void AddSubscriber(const KnownChannel& channel, const ChannelUser& user, std::size_t place) {
    Hypergraph::Channel& added = graph_.channels[place];
    added.types_differ = added.types_differ || Disagrees(channel, user);
    const SessionCounts::Use* const use = counts_.Find(user.session.value, channel.name);
    if (detail_.nodes && use != nullptr && !use->nodes.empty()) {
      for (const SessionCounts::Node& node : use->nodes) {
        const bool unnamed = node.name.starts_with(channel.name + "#");
        const std::string name = unnamed ? node.name.substr(channel.name.size()) : node.name;
        graph_.lines.push_back({PlaceOf(user, channel.name, name), place, false, user.lossless, OfNode(node, *use)});
      }
      return;
    }
    graph_.lines.push_back({PlaceOf(user, channel.name, {}), place, false, user.lossless,
                            use == nullptr ? std::nullopt : std::optional(OfSubscriber(*use))});
  }

  // If a publisher does not report its rate, the highest rate of a subscriber is a lower bound.
  void GuessRate(std::size_t place) {
    bool all_tell = true;
    std::optional<double> most;
    for (const Hypergraph::Line& line : graph_.lines) {
      if (line.channel != place) continue;
      if (line.publishes) {
        all_tell = all_tell && line.counts.has_value();
      } else if (line.counts && line.counts->per_second) {
        most = std::max(most.value_or(0), *line.counts->per_second);
      }
    }
    std::optional<double>& rate = graph_.channels[place].per_second;
    if (!all_tell && most) rate = std::max(rate.value_or(0), *most);
  }

  const SessionId own_;
  const SessionCounts& counts_;
  const HypergraphDetail detail_;
  Hypergraph graph_;
  std::map<Vertex, std::size_t> places_;
};

}  // namespace

Hypergraph MakeHypergraph(const std::vector<KnownChannel>& channels, SessionId own, const SessionCounts& counts,
                          HypergraphDetail detail) {
  Maker maker(own, counts, detail);
  for (const KnownChannel& channel : channels) maker.Add(channel);
  return std::move(maker).Done();
}

}  // namespace hgros::viewer
