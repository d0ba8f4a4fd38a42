#include "robot/hypergraph.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

namespace hgros::cli {
namespace {

std::string TransportBetween(const AllCounters& counters, SessionId from, SessionId to) {
  if (from == to) return "process";
  for (const auto& [mine, other] : {std::pair(from, to), std::pair(to, from)}) {
    const auto found = counters.find(mine);
    if (found == counters.end()) continue;
    for (const Snapshot::Peer& peer : found->second->peers()) {
      if (peer.session() == other.value) return peer.transport();
    }
  }
  return {};
}

}  // namespace

const Hypergraph::Node* Hypergraph::NodeOf(const Subscriber& subscriber) const {
  return subscriber.node ? &processes[subscriber.process].nodes[*subscriber.node] : nullptr;
}

Hypergraph Hypergraph::Of(const std::vector<KnownChannel>& channels, const AllCounters& counters) {
  Hypergraph graph;
  std::map<SessionId, std::size_t> places;
  const auto place_of = [&](const ChannelUser& user) {
    const auto [place, is_new] = places.emplace(user.session, graph.processes.size());
    if (is_new)
      graph.processes.push_back({user.session, ShortName(user, false), user.host, {}, 0, user.process, user.pid});
    return place->second;
  };
  for (const KnownChannel& known : channels) {
    Channel& channel = graph.channels.emplace_back();
    channel.name = known.name;
    channel.type = known.type_name;
    for (const ChannelUser& user : known.publishers) {
      const Snapshot::Channel* counted = CountersOf(counters, user.session, known.name);
      channel.publishers.push_back({place_of(user), counted == nullptr ? 0 : counted->rate_hz()});
      channel.rate_hz += channel.publishers.back().rate_hz;
      if (counted != nullptr) channel.latched = std::max<std::uint64_t>(channel.latched, counted->latched());
    }
    for (const ChannelUser& user : known.subscribers) {
      Subscriber subscriber{place_of(user), std::nullopt, {}};
      std::set<std::string> transports;
      for (const ChannelUser& from : known.publishers)
        transports.insert(TransportBetween(counters, from.session, user.session));
      transports.erase("");
      subscriber.transports.assign(transports.begin(), transports.end());
      std::vector<Node>& nodes = graph.processes[subscriber.process].nodes;
      const Snapshot::Channel* counted = CountersOf(counters, user.session, known.name);
      for (int i = 0; counted != nullptr && i < counted->nodes_size(); ++i) {
        const Snapshot::Node& node = counted->nodes(i);
        subscriber.node = nodes.size();
        nodes.push_back({node.name(), known.name, node.dropped(), node.lossless()});
        channel.subscribers.push_back(subscriber);
      }
      if (!subscriber.node) channel.subscribers.push_back(subscriber);
    }
  }
  graph.Arrange();
  return graph;
}

void Hypergraph::Arrange() {
  Rank();
  Sort();
}

// Longest paths from the sources. An edge that leads back to a process on the way to it, which closes a cycle, counts
// for nothing.
void Hypergraph::Rank() {
  std::vector<std::set<std::size_t>> next(processes.size());
  std::vector<bool> is_heard_by_none(processes.size(), true);
  std::vector<std::size_t> sources;
  for (const Channel& channel : channels) {
    for (const Publisher& publisher : channel.publishers) {
      for (const Subscriber& subscriber : channel.subscribers) {
        if (subscriber.process == publisher.process) continue;
        next[publisher.process].insert(subscriber.process);
        is_heard_by_none[subscriber.process] = false;
      }
    }
  }
  for (const bool first : {true, false}) {  // Then those that are only in cycles.
    for (std::size_t i = 0; i < processes.size(); ++i) {
      if (is_heard_by_none[i] == first) sources.push_back(i);
    }
  }
  // Depth first without recursion: `order` gets a process after all that it reaches.
  enum class State : unsigned char { kNew, kOpen, kDone };
  std::vector<State> states(processes.size(), State::kNew);
  std::vector<std::size_t> order;
  for (const std::size_t source : sources) {
    if (states[source] != State::kNew) continue;
    std::vector<std::pair<std::size_t, std::set<std::size_t>::iterator>> way{{source, next[source].begin()}};
    states[source] = State::kOpen;
    while (!way.empty()) {
      auto& [process, edge] = way.back();
      if (edge == next[process].end()) {
        states[process] = State::kDone;
        order.push_back(process);
        way.pop_back();
      } else if (states[*edge] == State::kOpen) {
        edge = next[process].erase(edge);  // Closes a cycle.
      } else {
        const std::size_t to = *edge++;
        if (states[to] != State::kNew) continue;
        states[to] = State::kOpen;
        way.emplace_back(to, next[to].begin());
      }
    }
  }
  for (auto process = order.rbegin(); process != order.rend(); ++process) {
    for (const std::size_t to : next[*process]) {
      processes[to].rank = std::max(processes[to].rank, processes[*process].rank + 1);
    }
  }
}

void Hypergraph::Sort() {
  std::vector<std::size_t> order(processes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [this](std::size_t i) {
    const Process& process = processes[i];
    return std::tuple(process.host, process.rank, process.name, process.session);
  });
  std::vector<std::size_t> places(order.size());
  std::vector<Process> sorted;
  for (std::size_t i = 0; i < order.size(); ++i) {
    places[order[i]] = i;
    sorted.push_back(std::move(processes[order[i]]));
  }
  processes = std::move(sorted);
  for (Channel& channel : channels) {
    for (Publisher& publisher : channel.publishers) publisher.process = places[publisher.process];
    for (Subscriber& subscriber : channel.subscribers) subscriber.process = places[subscriber.process];
    std::ranges::sort(channel.publishers, {}, &Publisher::process);
    std::ranges::stable_sort(channel.subscribers, {}, &Subscriber::process);
  }
  std::ranges::stable_sort(channels, {}, [](const Channel& channel) {
    return std::tuple(channel.publishers.empty(), channel.publishers.empty() ? 0 : channel.publishers.front().process,
                      channel.name);
  });
}

std::vector<std::string> Hypergraph::Names() const {
  std::set<std::string> names;
  for (const Process& process : processes) {
    names.insert(process.name);
    names.insert(process.program);
    names.insert(process.session.ToString());
    for (const Node& node : process.nodes) names.insert(node.name);
  }
  for (const Channel& channel : channels) names.insert(channel.name);
  return {names.begin(), names.end()};
}

std::optional<Hypergraph> Hypergraph::Around(std::string_view name, std::size_t depth) const {
  std::vector<bool> near(processes.size());
  std::vector<bool> joined(channels.size());
  for (std::size_t i = 0; i < processes.size(); ++i) {
    const Process& process = processes[i];
    near[i] = process.name == name || process.program == name || process.session.ToString() == name ||
              std::ranges::any_of(process.nodes, [&](const Node& node) { return node.name == name; });
  }
  const auto for_each_process = [this](std::size_t c, const auto& act) {
    for (const Publisher& publisher : channels[c].publishers) act(publisher.process);
    for (const Subscriber& subscriber : channels[c].subscribers) act(subscriber.process);
  };
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (channels[c].name != name) continue;
    joined[c] = true;
    for_each_process(c, [&](std::size_t process) { near[process] = true; });
  }
  if (std::ranges::none_of(near, [](bool is) { return is; }) &&
      std::ranges::none_of(joined, [](bool is) { return is; })) {
    return std::nullopt;
  }
  for (std::size_t step = 0; step < depth; ++step) {
    const std::vector<bool> before = near;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      bool touches = false;
      for_each_process(c, [&](std::size_t process) { touches = touches || before[process]; });
      if (!touches) continue;
      joined[c] = true;
      for_each_process(c, [&](std::size_t process) { near[process] = true; });
    }
  }
  Hypergraph part;
  std::vector<std::size_t> places(processes.size());
  for (std::size_t i = 0; i < processes.size(); ++i) {
    places[i] = part.processes.size();
    if (near[i]) part.processes.push_back(processes[i]);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!joined[c]) continue;
    Channel& channel = part.channels.emplace_back(channels[c]);
    for (Publisher& publisher : channel.publishers) publisher.process = places[publisher.process];
    for (Subscriber& subscriber : channel.subscribers) subscriber.process = places[subscriber.process];
  }
  return part;
}

}  // namespace hgros::cli
