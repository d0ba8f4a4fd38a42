#pragma once

#include <atomic>
#include <memory>

#include "graph/nodes/queued_node.hpp"
#include "graph/nodes/tbb_executor.hpp"

namespace hgros {

// Runs its callback on the work-stealing workers. Serial: at most one token is in flight, which empties the ring.
// Concurrent: one token per waiting message, but at most as many as there are workers, so that other nodes are not
// behind all of its messages.
class TbbNode final : public QueuedNode, public Activation {
 public:
  TbbNode(NodeSetting setting, AnyCallback callback, TbbExecutor& executor);

  void Activate() noexcept override;
  void HandToWorkers() noexcept override;
  [[nodiscard]] bool WouldWakeWorker() const noexcept override;
  void Close(bool wait) override;

 protected:
  bool NeedsWake() override;
  void Wake() noexcept override;

 private:
  // Number of messages in a row before other nodes get their turn, if that does not take kTurnNs.
  static constexpr std::size_t kTurn = 64;

  TbbExecutor& executor_;
  TbbExecutor::FlowNode& flow_node_;
  std::atomic<bool> flow_node_given_{false};
  // Tokens in flight (serial), or in flight and not started (concurrent). Written under mutex_.
  std::atomic<std::size_t> tokens_{0};
};

}  // namespace hgros
