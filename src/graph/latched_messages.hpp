#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "graph/queued_message.hpp"

namespace hgros {

class Node;

// What a channel keeps for late nodes: the last messages of each publisher. A publisher that is gone may only be cut
// off and then does not send again what it knows to have arrived, so its messages stay a while, unseen by new nodes;
// they get them when it returns.
//
// Thread safety: none, the channel locks. Messages that are let go of are returned: their destructors are the user's.
class LatchedMessages {
 public:
  using Messages = std::deque<QueuedMessage>;

  // Keeps the newest `depth` of the publisher's; returns those that go for it.
  [[nodiscard]] Messages Store(const AnyMessage& message, const MessageInfo& info, std::size_t depth);
  // Each message that is kept becomes what `make` makes of it.
  void Replace(const std::function<AnyMessage(AnyMessage)>& make);
  // What a new node gets, in the order of publishing.
  [[nodiscard]] std::vector<QueuedMessage> ForNewNode(const std::shared_ptr<Node>& node);

  // The publisher is gone. Returns what is let go of, since only few absent ones are kept.
  [[nodiscard]] Messages Leave(std::uint64_t publisher);
  // It is back: its messages, and the nodes that came meanwhile and have not seen them.
  struct Return {
    std::vector<QueuedMessage> messages;
    std::vector<std::shared_ptr<Node>> nodes;
  };
  [[nodiscard]] Return Come(std::uint64_t publisher);

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
