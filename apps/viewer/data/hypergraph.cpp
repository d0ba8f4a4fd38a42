#include "viewer/data/hypergraph.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

std::uint64_t DroppedBy(const SessionSnapshot& own, const std::string& channel) {
  std::uint64_t dropped = 0;
  for (const ChannelSnapshot& one : own.graph.channels) {
    if (one.name != channel) continue;
    for (const NodeSnapshot& node : one.nodes) dropped += node.dropped;
  }
  return dropped;
}

bool Disagrees(const KnownChannel& channel, const ChannelUser& user) {
  return !user.type_name.empty() &&
         (user.type_name != channel.type_name ||
          (user.fingerprint != 0 && channel.fingerprint != 0 && user.fingerprint != channel.fingerprint));
}

}  // namespace

Hypergraph MakeHypergraph(const std::vector<KnownChannel>& channels, const SessionSnapshot& own, Inner inner) {
  Hypergraph graph;
  std::map<std::uint64_t, Hypergraph::Process> users;
  const auto shown = [&](const KnownChannel& channel) {
    return inner == Inner::kShown || !channel.name.starts_with("hgros/");
  };
  for (const KnownChannel& channel : channels) {
    if (!shown(channel)) continue;
    for (const auto* side : {&channel.publishers, &channel.subscribers}) {
      for (const ChannelUser& user : *side) {
        users.try_emplace(user.session.value,
                          Hypergraph::Process{user.session, std::string(CutText(user.process)),
                                              std::string(CutText(user.host)), user.pid, user.session == own.id});
      }
    }
  }
  for (const auto& [id, process] : users) graph.processes.push_back(process);
  std::ranges::stable_sort(graph.processes, {}, &Hypergraph::Process::name);
  std::map<std::uint64_t, std::size_t> places;
  for (std::size_t i = 0; i < graph.processes.size(); ++i) places[graph.processes[i].session.value] = i;

  for (const KnownChannel& channel : channels) {
    if (!shown(channel)) continue;
    const std::size_t place = graph.channels.size();
    Hypergraph::Channel& added =
        graph.channels.emplace_back(Hypergraph::Channel{channel.name, channel.type_name, false});
    for (const ChannelUser& user : channel.publishers) {
      added.types_differ = added.types_differ || Disagrees(channel, user);
      graph.lines.push_back({places.at(user.session.value), place, true, false, 0});
    }
    for (const ChannelUser& user : channel.subscribers) {
      added.types_differ = added.types_differ || Disagrees(channel, user);
      graph.lines.push_back({places.at(user.session.value), place, false, user.lossless,
                             user.session == own.id ? DroppedBy(own, channel.name) : 0});
    }
  }
  return graph;
}

}  // namespace hgros::viewer
