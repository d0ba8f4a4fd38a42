#pragma once

#include "graph/nodes/queued_node.hpp"

namespace hgros {

// Messages wait until the program takes them on its own threads: RunWaiting(). Nothing here wakes a thread; a
// descriptor becomes readable instead.
//
// Invariants: the descriptor is readable exactly while messages wait, and after Close(). Both change under mutex_.
class PolledNode final : public QueuedNode {
 public:
  // Throws Error if the system has no descriptor left.
  PolledNode(NodeSetting setting, AnyCallback callback);
  ~PolledNode() override;

  std::size_t RunWaiting(std::size_t most) noexcept override;
  [[nodiscard]] int descriptor() const noexcept override { return event_; }
  void Close(bool wait) override;

 protected:
  bool NeedsWake() override;
  void Wake() noexcept override {}
  [[nodiscard]] bool RunsByItself() const noexcept override { return false; }

 private:
  void SetReadable(bool readable) noexcept;

  const int event_;
  bool readable_ = false;
};

}  // namespace hgros
