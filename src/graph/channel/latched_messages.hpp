#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "graph/nodes/queued_message.hpp"

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

  // Keeps the newest `depth` messages of the publisher and returns the ones that it removed.
  [[nodiscard]] Messages Store(const AnyMessage& message, const MessageInfo& info, std::size_t depth);
  // Replaces each message by the result of `make`.
  void Replace(const std::function<AnyMessage(AnyMessage)>& make);
  // The messages for a new node, in the order of publishing.
  [[nodiscard]] std::vector<QueuedMessage> ForNewNode(const std::shared_ptr<Node>& node);

  // Marks a publisher as gone. Returns removed messages, because only a few lost publishers are kept.
  [[nodiscard]] Messages MarkGone(std::uint64_t publisher);
  // Marks a publisher as back: its messages, and the nodes added meanwhile that have not seen them.
  struct Return {
    std::vector<QueuedMessage> messages;
    std::vector<std::shared_ptr<Node>> nodes;
  };
  [[nodiscard]] Return MarkBack(std::uint64_t publisher);

 private:
  static constexpr std::size_t kMostAbsent = 4;

  struct Entry {
    Messages messages;
    std::uint64_t absent_since = 0;  // 0: present.
    std::vector<std::weak_ptr<Node>> missed;
  };

  std::map<std::uint64_t, Entry> entries_;  // By publisher id.
  std::uint64_t leaves_ = 0;
};

}  // namespace hgros
