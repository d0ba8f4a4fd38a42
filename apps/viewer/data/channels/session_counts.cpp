#include "viewer/data/channels/session_counts.hpp"

#include <algorithm>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

using Flow = SessionCounts::Flow;
using Node = SessionCounts::Node;
using Use = SessionCounts::Use;

constexpr double kNsPerSecond = 1e9;

/// There is no rate without an earlier report, or if the session has restarted.
Flow Grown(std::uint64_t messages, const Flow* before, double seconds) {
  Flow flow{messages, {}};
  if (before != nullptr && seconds > 0 && messages >= before->messages) {
    flow.per_second = static_cast<double>(messages - before->messages) / seconds;
  }
  return flow;
}

Node ReadNode(const Snapshot::Node& told, const Use* before, double seconds) {
  Node node;
  node.name = CutText(told.name());
  const Flow* last = nullptr;
  if (before != nullptr) {
    const auto same = std::ranges::find(before->nodes, node.name, &Node::name);
    if (same != before->nodes.end()) last = &same->received;
  }
  node.received = Grown(told.received(), last, seconds);
  node.dropped = told.dropped();
  node.failed = told.failed();
  node.queued = told.queued();
  node.run_p50_ns = told.run_p50_ns();
  node.run_p99_ns = told.run_p99_ns();
  return node;
}

// `nodes` counts the nodes of all channels.
Use ReadUse(const Snapshot::Channel& told, const Use* before, double seconds, std::size_t& nodes) {
  Use use;
  use.published = Grown(told.published(), before == nullptr ? nullptr : &before->published, seconds);
  use.refused = told.refused();
  use.send_dropped = told.send_dropped();
  use.received = Grown(told.received(), before == nullptr ? nullptr : &before->received, seconds);
  use.lost = told.lost();
  use.faults = told.faults();
  for (const Snapshot::Node& node : told.nodes()) {
    if (nodes++ >= SessionCounts::kMaxNodes) break;
    use.nodes.push_back(ReadNode(node, before, seconds));
  }
  std::ranges::sort(use.nodes, {}, &Node::name);
  return use;
}

}  // namespace

void SessionCounts::Add(std::uint64_t session, const Snapshot& snapshot) {
  Told& told = sessions_[session];
  const double seconds =
      (static_cast<double>(snapshot.steady_ns()) - static_cast<double>(told.steady_ns)) / kNsPerSecond;
  std::size_t nodes = 0;
  std::map<std::string, Use> channels;
  for (const Snapshot::Channel& channel : snapshot.channels()) {
    if (channels.size() == kMaxChannels) break;
    const auto before = told.channels.find(channel.name());
    channels.emplace(channel.name(),
                     ReadUse(channel, before == told.channels.end() ? nullptr : &before->second, seconds, nodes));
  }
  told = {snapshot.steady_ns(), std::move(channels)};
}

void SessionCounts::Keep(const std::set<std::uint64_t>& sessions) {
  std::erase_if(sessions_, [&](const auto& entry) { return !sessions.contains(entry.first); });
}

const Use* SessionCounts::Find(std::uint64_t session, const std::string& channel) const {
  const auto told = sessions_.find(session);
  if (told == sessions_.end()) return nullptr;
  const auto use = told->second.channels.find(channel);
  return use == told->second.channels.end() ? nullptr : &use->second;
}

}  // namespace hgros::viewer
