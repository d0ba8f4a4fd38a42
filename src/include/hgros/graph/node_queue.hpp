#pragma once

#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/graph/message_info.hpp"
#include "hgros/graph/subscription.hpp"

namespace hgros {

class GraphCore;
class Node;

// The queue of a subscription, for one who keeps some of its messages elsewhere. Does nothing once the subscription has
// ended.
//
// Thread safety: all functions, also inside the callback, except for idle().
class HGROS_EXPORT NodeQueue {
 public:
  // None.
  NodeQueue() = default;
  // None if the executor has no queue, or the subscription has ended.
  explicit NodeQueue(const Subscription& subscription);
  explicit operator bool() const noexcept { return there_; }

  // Messages wait (true), or go on. The running callback may still get some that it has taken out already.
  void Suspend(bool suspended) const;
  // Calls the callback with a null message and `info` before all messages that wait, also while they are suspended.
  // It is not counted.
  void CallWithoutMessage(const MessageInfo& info) const;
  // No message waits, and no callback runs.
  [[nodiscard]] bool idle() const;
  // A message was dropped because newer ones came.
  void CountDropped() const noexcept;

 private:
  bool there_ = false;
  std::weak_ptr<GraphCore> graph_;
  std::weak_ptr<Node> node_;
};

}  // namespace hgros
