#pragma once

#include <memory>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/graph/snapshot.hpp"

namespace hgros {

class Channel;
class GraphCore;
class Node;

/// Keeps a callback wired to its channel; move-only.
///
/// Lifetime: destroying it stops new callbacks at once. Outside callbacks it waits for those in flight; inside any
/// callback of the same graph it does not wait, and what the callback captured lives until it returns.
/// It may outlive its graph; it is then inert. Thread-safe but for moves and the destructor.
class HGROS_EXPORT Subscription {
 public:
  Subscription() = default;
  /// For DataGraph, which has made the node.
  Subscription(std::shared_ptr<GraphCore> core, Channel& channel, std::shared_ptr<Node> node);
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept;
  ~Subscription();

  /// Ends the subscription and waits for callbacks in flight wherever it is called. Returns false, without waiting,
  /// if called from within this subscription's own callback.
  bool Join();
  /// Ends the subscription as the destructor does.
  void Reset();

  [[nodiscard]] bool active() const;
  /// The node's name, as configuration and tables know it; empty if inactive.
  [[nodiscard]] std::string name() const;
  [[nodiscard]] NodeSnapshot stats() const;
  /// Hands over something to be released when the subscription ends, before its node. For the session.
  void Attach(std::shared_ptr<const void> companion);

 private:
  struct State;

  [[nodiscard]] std::shared_ptr<Node> Current() const;
  void End(bool wait);
  bool WaitForEnded(bool in_callbacks_too);

  std::shared_ptr<State> state_;
};

}  // namespace hgros
