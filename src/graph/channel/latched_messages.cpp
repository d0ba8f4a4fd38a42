#include "graph/channel/latched_messages.hpp"

#include <algorithm>
#include <utility>

#include "graph/nodes/node.hpp"

namespace hgros {

LatchedMessages::Messages LatchedMessages::Store(const AnyMessage& message, const MessageInfo& info,
                                                 std::size_t depth) {
  Messages dropped;
  Entry& entry = entries_[info.id.publisher];
  entry.absent_since = 0;  // A publisher that sends is present; nodes that missed older messages get this one.
  entry.missed.clear();
  Messages& kept = entry.messages;
  // A restarted publisher has sent its latched messages again.
  if (!kept.empty() && kept.back().info.id.incarnation != info.id.incarnation) dropped.swap(kept);
  kept.push_back({message, info, nullptr, 0});
  while (kept.size() > depth) {
    dropped.push_back(std::move(kept.front()));
    kept.pop_front();
  }
  return dropped;
}

void LatchedMessages::Replace(const std::function<AnyMessage(AnyMessage)>& make) {
  for (auto& [publisher, entry] : entries_) {
    for (QueuedMessage& one : entry.messages) one.message = make(std::move(one.message));
  }
}

std::vector<QueuedMessage> LatchedMessages::ForNewNode(const std::shared_ptr<Node>& node) {
  std::vector<QueuedMessage> messages;
  for (auto& [publisher, entry] : entries_) {
    if (entry.absent_since > 0) {
      std::erase_if(entry.missed, [](const std::weak_ptr<Node>& one) { return one.expired(); });
      entry.missed.push_back(node);
    } else {
      messages.insert(messages.end(), entry.messages.begin(), entry.messages.end());
    }
  }
  std::stable_sort(messages.begin(), messages.end(), [](const QueuedMessage& a, const QueuedMessage& b) {
    return a.info.publish_monotonic_ns < b.info.publish_monotonic_ns;
  });
  return messages;
}

LatchedMessages::Messages LatchedMessages::MarkGone(std::uint64_t publisher) {
  Messages dropped;
  const auto gone = entries_.find(publisher);
  if (gone == entries_.end()) return dropped;
  gone->second.absent_since = ++leaves_;
  auto longest = entries_.end();
  std::size_t absent = 0;
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->second.absent_since == 0) continue;
    ++absent;
    if (longest == entries_.end() || entry->second.absent_since < longest->second.absent_since) longest = entry;
  }
  if (absent > kMostAbsent) {
    dropped.swap(longest->second.messages);
    entries_.erase(longest);
  }
  return dropped;
}

LatchedMessages::Return LatchedMessages::MarkBack(std::uint64_t publisher) {
  Return back;
  const auto found = entries_.find(publisher);
  if (found == entries_.end()) return back;
  Entry& entry = found->second;
  entry.absent_since = 0;
  for (const std::weak_ptr<Node>& missed : std::exchange(entry.missed, {})) {
    if (std::shared_ptr<Node> node = missed.lock()) back.nodes.push_back(std::move(node));
  }
  if (!back.nodes.empty()) back.messages.assign(entry.messages.begin(), entry.messages.end());
  return back;
}

}  // namespace hgros
