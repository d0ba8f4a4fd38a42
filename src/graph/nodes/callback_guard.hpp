#pragma once

#include <condition_variable>
#include <mutex>
#include <utility>

#include "hgros/internal/graph/callback.hpp"

namespace hgros {

class GraphCore;
class Node;

// A node's callback. It is destroyed once, after the node was closed, when no callback runs any more. Its captures
// may include a Subscription of this very node. So it is destroyed outside the node's lock, and the thread is marked
// as inside the node's callback: then this Subscription does not wait for itself.
//
// Thread safety: operator() is called by the threads that the node lets run its callback; everything else is guarded
// by the node's mutex.
class CallbackGuard {
 public:
  explicit CallbackGuard(AnyCallback callback) : callback_(std::move(callback)) {}

  void operator()(const AnyMessage& message, const MessageInfo& info) { callback_(message, info); }

  // Destroys the callback unless that was done before. The caller has made sure that no callback of `node` runs and
  // that none will. `lock` holds the node's mutex and is released meanwhile; `changed` is notified afterwards. `graph`
  // is set on a thread that has just run the callback: what the captures end does not wait for that thread.
  void DestroyOnce(GraphCore* graph, Node* node, std::unique_lock<std::mutex>& lock,
                   std::condition_variable& changed) noexcept;
  // A thread is in DestroyOnce(): threads that wait for the node must wait for this, too.
  [[nodiscard]] bool destroying() const noexcept { return destroying_; }

 private:
  AnyCallback callback_;
  bool destroyed_ = false;
  bool destroying_ = false;
};

}  // namespace hgros
