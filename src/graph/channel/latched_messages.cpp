#include "graph/channel/latched_messages.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>

#include "graph/nodes/node.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

void LatchedMessages::RemoveOldest(Messages& from, Messages& removed) {
  if (from.front().info.remote) {
    --remote_messages_;
    remote_bytes_ -= from.front().bytes;
  }
  removed.push_back(std::move(from.front()));
  from.pop_front();
}

void LatchedMessages::RemoveAll(Messages& from, Messages& removed) {
  while (!from.empty()) RemoveOldest(from, removed);
}

LatchedMessages::Entries::iterator LatchedMessages::LongestAbsent() {
  auto longest = entries_.end();
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->second.absent_since == 0) continue;
    if (longest == entries_.end() || entry->second.absent_since < longest->second.absent_since) longest = entry;
  }
  return longest;
}

LatchedMessages::Stored LatchedMessages::Store(const AnyMessage& message, const MessageInfo& info, std::size_t depth,
                                               std::size_t bytes) {
  Stored stored;
  Entry& entry = entries_[info.id.publisher];
  entry.absent_since = 0;  // A publisher that sends is present.
  Messages& kept = entry.messages;
  // A restarted publisher has sent its latched messages again.
  if (!kept.empty() && kept.back().info.id.incarnation != info.id.incarnation) {
    RemoveAll(kept, stored.removed);
  }
  kept.push_back({message, info, nullptr, bytes});
  if (info.remote) {
    ++remote_messages_;
    remote_bytes_ += bytes;
  }
  while (kept.size() > depth) RemoveOldest(kept, stored.removed);
  if (!info.remote) return stored;
  while (IsBeyondLimit()) {
    const auto absent = LongestAbsent();
    if (absent == entries_.end()) break;
    RemoveAll(absent->second.messages, stored.removed);
    entries_.erase(absent);
  }
  while (IsBeyondLimit() && !kept.empty()) {
    RemoveOldest(kept, stored.removed);
    ++stored.beyond_limit;
  }
  if (kept.empty()) entries_.erase(info.id.publisher);
  return stored;
}

LatchedMessages::Messages LatchedMessages::ReplaceOwn(const MessageInfo& info, std::vector<AnyMessage> messages,
                                                      std::uint64_t other) {
  Messages removed;
  for (const std::uint64_t publisher : {info.id.publisher, other}) {
    if (const auto found = entries_.find(publisher); found != entries_.end()) {
      RemoveAll(found->second.messages, removed);
      entries_.erase(found);
    }
  }
  for (const AnyMessage& message : messages) (void)Store(message, info, messages.size(), 0);
  return removed;
}

LatchedMessages::Messages LatchedMessages::ForgetRemote() {
  Messages removed;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    Messages& messages = entry->second.messages;
    const bool own = !messages.empty() && !messages.front().info.remote;
    if (!own) RemoveAll(messages, removed);
    entry = own ? std::next(entry) : entries_.erase(entry);
  }
  return removed;
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
  for (QueuedMessage& one : messages) one.bytes = 0;  // It is not the size that a queue counts.
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
  const auto absent = std::ranges::count_if(entries_, [](const auto& one) { return one.second.absent_since > 0; });
  if (static_cast<std::size_t>(absent) > kMostAbsent) {
    const auto longest = LongestAbsent();
    RemoveAll(longest->second.messages, dropped);
    entries_.erase(longest);
  }
  return dropped;
}

bool LatchedMessages::AreMissed(std::uint64_t publisher) const {
  const auto found = entries_.find(publisher);
  return found != entries_.end() && !found->second.missed.empty();
}

LatchedMessages::Return LatchedMessages::MarkBack(std::uint64_t publisher, std::optional<std::uint64_t> incarnation) {
  Return back;
  const auto found = entries_.find(publisher);
  if (found == entries_.end()) return back;
  Entry& entry = found->second;
  entry.absent_since = 0;
  for (const std::weak_ptr<Node>& missed : std::exchange(entry.missed, {})) {
    if (std::shared_ptr<Node> node = missed.lock()) back.nodes.push_back(std::move(node));
  }
  const bool current =
      !incarnation || (!entry.messages.empty() && entry.messages.back().info.id.incarnation == *incarnation);
  if (current && !back.nodes.empty()) back.messages.assign(entry.messages.begin(), entry.messages.end());
  return back;
}

void LatchedMessages::Return::Deliver() {
  std::int64_t now = MonotonicNow();
  for (const std::shared_ptr<Node>& node : nodes) {
    for (QueuedMessage& one : messages) {
      node->Deliver({one.message, one.info, one.credit, one.bytes, false}, false, now);
    }
  }
}

void LatchedMessages::SayBeyondLimit(Log& log, const std::string& channel) {
  log.WriteLimited(LogLevel::kWarning, "not latched " + channel,
                   "Other sessions latch more on channel \"" + channel + "\" than is kept here (" +
                       std::to_string(kMostRemoteMessages) + " messages, " + std::to_string(kMostRemoteBytes >> 20) +
                       " MiB): nodes that are added later do not get the rest. Latch less.",
                   std::chrono::hours(1));
}

}  // namespace hgros
