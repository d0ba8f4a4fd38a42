#include "graph/tbb_node.hpp"

#include <utility>

#include "graph/spin_then_lock.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

TbbNode::TbbNode(NodeSetting setting, AnyCallback callback, TbbExecutor& executor)
    : QueuedNode(std::move(setting), std::move(callback)), executor_(executor), flow_node_(executor.Take()) {}

// A token that is still out does no harm in another node's hands: tokens say themselves what they set going.
void TbbNode::Close(bool wait) {
  QueuedNode::Close(wait);
  if (!flow_node_given_.exchange(true)) executor_.Give(flow_node_);
}

bool TbbNode::NeedsWake() {
  const std::size_t wanted = setting().invoke == Invoke::kSerial ? 1 : QueuedHere();
  const std::size_t tokens = tokens_.load(std::memory_order_relaxed);
  if (tokens >= wanted) return false;
  tokens_.store(tokens + 1, std::memory_order_relaxed);
  return true;
}

void TbbNode::Wake() noexcept {
  auto self = std::static_pointer_cast<TbbNode>(shared_from_this());
  if (executor_.KeepsHere(self)) return;
  if (setting().invoke == Invoke::kSerial) {
    TbbExecutor::Put(flow_node_, std::move(self), ticket_);
  } else {
    TbbExecutor::Put(flow_node_, std::move(self));
  }
}

void TbbNode::PassOn() noexcept { executor_.Enqueue(std::static_pointer_cast<TbbNode>(shared_from_this())); }

// A node that is running gets the next message without anybody's help.
bool TbbNode::AwaitsHelp() const noexcept {
  return tokens_.load(std::memory_order_relaxed) == 0 && !executor_.helped();
}

void TbbNode::Activate() noexcept {
  std::int64_t now = MonotonicNow();
  std::unique_lock lock(mutex_, std::defer_lock);
  SpinThenLock(lock);
  if (setting().invoke == Invoke::kConcurrent) {
    tokens_.store(tokens_.load(std::memory_order_relaxed) - 1, std::memory_order_relaxed);
    RunSome(lock, 1, now);
    return;
  }
  RunSome(lock, kTurn, now);
  if (HasMessages() && !closed_) {
    lock.unlock();
    PassOn();  // The token goes to the end of the line.
  } else {
    tokens_.store(0, std::memory_order_relaxed);
  }
}

}  // namespace hgros
