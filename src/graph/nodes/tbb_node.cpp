#include "graph/nodes/tbb_node.hpp"

#include <algorithm>
#include <utility>

#include "graph/nodes/spin_then_lock.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

TbbNode::TbbNode(NodeSetting setting, AnyCallback callback, TbbExecutor& executor)
    : QueuedNode(std::move(setting), std::move(callback)),
      executor_(executor),
      flow_node_(executor.AcquireFlowNode()) {}

// A token that is still in flight does no harm if another node gets the flow-graph node: it only says that a node is
// ready.
void TbbNode::Close(bool wait) {
  QueuedNode::Close(wait);
  if (!flow_node_given_.exchange(true)) executor_.ReleaseFlowNode(flow_node_);
}

bool TbbNode::NeedsWake() {
  const std::size_t wanted = setting().invoke == Invoke::kSerial ? 1 : std::min(RunnableHere(), executor_.workers());
  const std::size_t tokens = tokens_.load(std::memory_order_relaxed);
  if (tokens >= wanted) return false;
  tokens_.store(tokens + 1, std::memory_order_relaxed);
  return true;
}

void TbbNode::Wake() noexcept {
  auto self = std::static_pointer_cast<TbbNode>(shared_from_this());
  if (!executor_.KeepForThisThread(self)) executor_.Put(flow_node_, std::move(self));
}

void TbbNode::HandToWorkers() noexcept { executor_.Enqueue(std::static_pointer_cast<TbbNode>(shared_from_this())); }

// A running node gets the next message without waking a worker.
bool TbbNode::WouldWakeWorker() const noexcept {
  return tokens_.load(std::memory_order_relaxed) == 0 && !executor_.slot_taken();
}

void TbbNode::Activate() noexcept {
  std::int64_t now = MonotonicNow();
  std::unique_lock lock(mutex_, std::defer_lock);
  SpinThenLock(lock);
  if (setting().invoke == Invoke::kConcurrent) {
    const std::size_t tokens = tokens_.load(std::memory_order_relaxed);
    if (RunnableHere() > tokens && !closed_) {
      lock.unlock();
      HandToWorkers();
      SpinThenLock(lock);
    } else {
      tokens_.store(tokens - 1, std::memory_order_relaxed);
    }
    RunSome(lock, kTurn, now, now + kTurnNs);
    return;
  }
  RunSome(lock, kTurn, now, now + kTurnNs);
  if (MayRun() && !closed_) {
    lock.unlock();
    HandToWorkers();  // The token goes to the end of the workers' queue.
  } else {
    tokens_.store(0, std::memory_order_relaxed);
  }
}

}  // namespace hgros
