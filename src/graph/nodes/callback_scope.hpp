#pragma once

#include <vector>

#include "hgros/base/cause.hpp"

namespace hgros {

class GraphCore;
class Node;

// Marks the calling thread as running a callback of `node` in `graph`, with the cause of what it publishes. Scopes
// nest: an inline callback that publishes runs other callbacks inside it. If exit() is called inside a scope, its graph
// ends before any static object does.
class CallbackScope {
 public:
  explicit CallbackScope(GraphCore* graph, Node* node, const Cause& cause = {}) noexcept;
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;
  ~CallbackScope();

  [[nodiscard]] static bool InAny() noexcept;
  [[nodiscard]] static bool InGraph(const GraphCore* graph) noexcept;
  [[nodiscard]] static bool InNode(const Node* node) noexcept;
  // The innermost node of `graph` whose callback this thread runs; null if there is none.
  [[nodiscard]] static const Node* NodeOf(const GraphCore* graph) noexcept;
  // The node whose callback this thread runs; null if it runs none.
  [[nodiscard]] static Node* Innermost() noexcept;
  // The nodes whose callbacks this thread runs, each as often as it does.
  [[nodiscard]] static std::vector<const Node*> Nodes();

 private:
  struct ExitWatch;

  GraphCore* graph_;
  Node* node_;
  CallbackScope* outer_;
  const Cause cause_;
  const Cause* const outer_cause_;
};

}  // namespace hgros
