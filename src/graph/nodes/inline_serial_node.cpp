#include "graph/nodes/inline_serial_node.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "hgros/clock/time.hpp"

namespace hgros {

InlineSerialNode::InlineSerialNode(NodeSetting setting, AnyCallback callback)
    : Node(std::move(setting), std::move(callback)), ring_(Node::setting().queue) {}

void InlineSerialNode::Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept {
  int expected = kIdle;
  // A reservation is returned through the ring's own count, so such messages take the slow way.
  if ((reserved || !state_.compare_exchange_strong(expected, kRunning, std::memory_order_seq_cst)) &&
      LeaveInRing(delivery, reserved)) {
    return;
  }
  if (reserved) NotifyRoom();  // The reservation was returned unused: the callback runs now.
  Add(direct_, std::uint64_t{1}, Writers::kOne);
  RunOne(delivery.message, delivery.info, now);
  Drain(now);
}

// True if the running thread will find the message in the ring; false if the caller has become the running thread.
bool InlineSerialNode::LeaveInRing(const Delivery& delivery, bool reserved) {
  std::optional<QueuedMessage> dropped;  // Destroyed after the lock.
  std::unique_lock lock(mutex_);
  if (reserved) ring_.Cancel(delivery.bytes);
  for (int state = state_.load(std::memory_order_seq_cst);;) {
    if (state == kIdle) {
      if (state_.compare_exchange_weak(state, kRunning, std::memory_order_seq_cst)) return false;
    } else if (state_.compare_exchange_weak(state, kPending, std::memory_order_seq_cst)) {
      break;
    }
  }
  left_in_ring_.fetch_add(1, std::memory_order_relaxed);
  dropped = ring_.Push(delivery);
  if (dropped) dropped_.fetch_add(1, std::memory_order_relaxed);
  lock.unlock();
  if (dropped) [[unlikely]]
    SayDropped();
  return true;
}

void InlineSerialNode::RunOne(const AnyMessage& message, const MessageInfo& info, std::int64_t& now) noexcept {
  if (!closed_.load(std::memory_order_seq_cst)) Run(message, info, stats_, Writers::kOne, now);
}

// Runs the messages that other threads left in the ring, then becomes idle.
void InlineSerialNode::Drain(std::int64_t& now) noexcept {
  for (int running = kRunning; !state_.compare_exchange_strong(running, kIdle, std::memory_order_seq_cst);
       running = kRunning) {
    QueuedMessage next;
    {
      const std::scoped_lock lock(mutex_);
      if (!ring_.empty()) next = ring_.Pop();
      if (ring_.empty()) state_.store(kRunning, std::memory_order_seq_cst);
    }
    if (next.message == nullptr) continue;
    next.credit.reset();
    if (lossless()) NotifyRoom();
    RunOne(next.message, next.info, now);
  }
  Finish();
}

void InlineSerialNode::Finish() noexcept {
  // Sequentially consistent with Close() and WaitIdle(): either they see kIdle, or this sees them.
  if (watchers_.load(std::memory_order_seq_cst) == 0 && !closed_.load(std::memory_order_seq_cst)) return;
  std::unique_lock lock(mutex_);
  idle_.notify_all();
  if (closed_) DestroyCallbackIfIdle(true, lock);
}

// Every thread that takes kRunning after closed_ was set leaves the callback alone, so no thread uses the callback of a
// node that is closed and idle.
void InlineSerialNode::DestroyCallbackIfIdle(bool after_run, std::unique_lock<std::mutex>& lock) noexcept {
  if (state_.load(std::memory_order_seq_cst) == kIdle) DestroyCallbackOnce(after_run, lock, idle_);
}

bool InlineSerialNode::Reserve(std::size_t bytes) noexcept {
  const std::scoped_lock lock(mutex_);
  if (closed_ || ring_.Reserve(bytes)) return true;
  refused_ = true;
  return false;
}

bool InlineSerialNode::CancelReservation(std::size_t bytes) noexcept {
  const std::scoped_lock lock(mutex_);
  ring_.Cancel(bytes);
  return std::exchange(refused_, false);
}

void InlineSerialNode::Preload(std::vector<QueuedMessage> messages) {
  preloaded_ = std::move(messages);
  if (!preloaded_.empty()) state_ = kRunning;
}

void InlineSerialNode::Start() {
  if (preloaded_.empty()) return;
  std::int64_t now = MonotonicNow();
  Add(direct_, std::uint64_t{preloaded_.size()}, Writers::kOne);
  for (const QueuedMessage& message : preloaded_) RunOne(message.message, message.info, now);
  preloaded_.clear();
  Drain(now);
}

void InlineSerialNode::Close(bool wait) {
  closed_.store(true, std::memory_order_seq_cst);
  std::vector<QueuedMessage> discarded;  // Destroyed after the lock.
  std::unique_lock lock(mutex_);
  while (!ring_.empty()) discarded.push_back(ring_.Pop());
  lock.unlock();
  NotifyRoom();  // Publishers must not wait for a closed node.
  lock.lock();
  if (wait) {
    idle_.wait(lock, [this] { return state_.load(std::memory_order_seq_cst) == kIdle && !destroying_callback(); });
  }
  DestroyCallbackIfIdle(false, lock);
}

bool InlineSerialNode::WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) {
  watchers_.fetch_add(1, std::memory_order_seq_cst);
  std::unique_lock lock(mutex_);
  const bool idle = idle_.wait_until(
      lock, deadline, [this, own] { return own > 0 || state_.load(std::memory_order_seq_cst) == kIdle; });
  watchers_.fetch_sub(1, std::memory_order_seq_cst);
  return idle;
}

void InlineSerialNode::AddStats(NodeSnapshot& snapshot) const {
  Node::AddStats(snapshot);
  snapshot.received = direct_.load(std::memory_order_relaxed) + left_in_ring_.load(std::memory_order_relaxed);
}

std::size_t InlineSerialNode::QueuedNow() const {
  const std::scoped_lock lock(mutex_);
  return ring_.size();
}

}  // namespace hgros
