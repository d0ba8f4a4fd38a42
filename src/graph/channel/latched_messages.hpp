#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph/nodes/queued_message.hpp"
#include "hgros/base/log.hpp"

namespace hgros {

class Node;

// The last messages of each publisher, which a channel keeps for late nodes. A lost publisher may only be
// disconnected, and then it does not repeat messages that have arrived. So its messages are kept for a while but
// hidden from new nodes, which get them when it returns.
//
// Thread safety: none; the channel locks. Removed messages are returned, because their destructors are user code.
class LatchedMessages {
 public:
  using Messages = std::deque<QueuedMessage>;

  // Limits of the messages of other sessions, which name the depth themselves. A single message may be larger.
  static constexpr std::size_t kMostRemoteBytes = 64u << 20;
  static constexpr std::size_t kMostRemoteMessages = 16384;

  // Keeps the newest `depth` messages of the publisher. `bytes` is the message's size, for messages of other sessions.
  // At their limit, those of publishers that are gone make room, then older ones of the same publisher. If that is not
  // enough, the message is not kept: so no publisher can remove another's.
  struct Stored {
    Messages removed;
    std::size_t beyond_limit = 0;  // Messages of this publisher that were removed because of the limits.
  };
  [[nodiscard]] Stored Store(const AnyMessage& message, const MessageInfo& info, std::size_t depth, std::size_t bytes);
  // Logs that messages were not kept; not to be called under the channel's lock, because the log is user code.
  static void SayBeyondLimit(Log& log, const std::string& channel);
  // Keeps these in place of what their publisher and `other` have latched, and returns that. All get this info, and are
  // not remote.
  [[nodiscard]] Messages ReplaceOwn(const MessageInfo& info, std::vector<AnyMessage> messages, std::uint64_t other);
  // Forgets the messages of other sessions, and returns them.
  [[nodiscard]] Messages ForgetRemote();
  // Replaces each message by the result of `make`.
  void Replace(const std::function<AnyMessage(AnyMessage)>& make);
  // The messages for a new node, in the order of publishing.
  [[nodiscard]] std::vector<QueuedMessage> ForNewNode(const std::shared_ptr<Node>& node);

  // Marks a publisher as gone. Returns removed messages, because only a few lost publishers are kept.
  [[nodiscard]] Messages MarkGone(std::uint64_t publisher);
  // Marks a publisher as back: its messages, and the nodes added meanwhile that have not seen them. `incarnation`: only
  // messages of this one, if it is known.
  struct Return {
    std::vector<QueuedMessage> messages;
    std::vector<std::shared_ptr<Node>> nodes;

    // Not to be called under the channel's lock, because callbacks may run.
    void Deliver();
  };
  [[nodiscard]] Return MarkBack(std::uint64_t publisher, std::optional<std::uint64_t> incarnation = std::nullopt);
  // Nodes have not seen messages of this publisher.
  [[nodiscard]] bool AreMissed(std::uint64_t publisher) const;

 private:
  static constexpr std::size_t kMostAbsent = 4;

  struct Entry;
  using Entries = std::map<std::uint64_t, Entry>;  // By publisher id.
  [[nodiscard]] bool IsBeyondLimit() const noexcept {
    return remote_messages_ > 1 && (remote_messages_ > kMostRemoteMessages || remote_bytes_ > kMostRemoteBytes);
  }
  void RemoveOldest(Messages& from, Messages& removed);
  void RemoveAll(Messages& from, Messages& removed);
  [[nodiscard]] Entries::iterator LongestAbsent();

  struct Entry {
    Messages messages;
    std::uint64_t absent_since = 0;  // 0: present.
    std::vector<std::weak_ptr<Node>> missed;
  };

  Entries entries_;
  std::size_t remote_messages_ = 0;
  std::size_t remote_bytes_ = 0;
  std::uint64_t leaves_ = 0;
};

}  // namespace hgros
