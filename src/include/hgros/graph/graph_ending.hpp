#pragma once

#include <functional>
#include <string>

#include "hgros/graph/data_graph.hpp"

namespace hgros {

// The end of a graph inside one of its own callbacks: its owner is destroyed there, or exit() is called there. The
// thread cannot wait for its own callback, so the graph is closed and then kept until the process ends.
//
// Thread safety: all functions.
class GraphEnding {
 public:
  explicit GraphEnding(DataGraph& graph) : graph_(graph) {}

  // `on_exit` is called if exit() is called inside a callback, before any static object is destroyed. It calls End().
  void SetOnExit(std::function<void()> on_exit);
  // The innermost callback of the graph that this thread runs, as `node "x" on channel "y"`. Empty if it runs none.
  [[nodiscard]] std::string CallbackHere() const;
  // From now on no callback starts. Waits for the callbacks of other threads, then calls `leave`; both on another
  // thread and for a limited time. Afterwards neither the graph nor what its callbacks use may be destroyed. Only the
  // first call does this.
  void End(std::function<void()> leave) noexcept;
  // End() was called.
  [[nodiscard]] bool ended() const noexcept;

 private:
  DataGraph& graph_;
};

}  // namespace hgros
