#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/graph/snapshot.hpp"

namespace hgros {

class Channel;
class GraphCore;
class Node;

/// Keeps a callback subscribed to its channel; move-only.
///
/// Lifetime: destroying it stops new callbacks at once. Outside callbacks it waits for the running ones. Inside a
/// callback of the same graph it does not wait, and captured objects live until the callback returns. It may outlive
/// its graph and then does nothing. Thread-safe except for moves and the destructor.
class HGROS_EXPORT Subscription {
 public:
  Subscription() = default;
  /// For DataGraph, which has created the node.
  Subscription(std::shared_ptr<GraphCore> core, Channel& channel, std::shared_ptr<Node> node);
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept;
  ~Subscription();

  /// Ends the subscription and waits for running callbacks, inside other callbacks too. Returns false without waiting
  /// inside this subscription's own callback.
  bool Join();
  /// Ends the subscription as the destructor does.
  void Reset();

  /// With Executor::Polled(): calls the callback on this thread with `most` of the waiting messages, the oldest first,
  /// or with fewer if no more wait. Returns how many; always 0 with another executor. Never waits. Several threads may
  /// call it: each message goes to one of them.
  std::size_t RunWaiting(std::size_t most = 1);
  /// With Executor::Polled(): a descriptor that is readable while messages wait, and once the subscription or its
  /// session has ended. Wait for it with poll() and the like; neither read, write nor close it. Valid while the
  /// subscription is active; -1 otherwise, and with another executor.
  [[nodiscard]] int descriptor() const;

  [[nodiscard]] bool active() const;
  /// The node's name in configuration and tables; empty if inactive.
  [[nodiscard]] std::string name() const;
  [[nodiscard]] NodeSnapshot stats() const;
  /// For the session: an object that is released when the subscription ends, before its node.
  void Attach(std::shared_ptr<const void> companion);

 private:
  friend class NodeQueue;
  struct State;

  [[nodiscard]] std::shared_ptr<Node> Current() const;
  void End(bool wait);
  bool WaitForEnded(bool in_callbacks_too);

  std::shared_ptr<State> state_;
};

}  // namespace hgros
