#include "graph/queued_node.hpp"

#include <optional>
#include <utility>

#include "hgros/clock/time.hpp"

namespace hgros {

QueuedNode::QueuedNode(NodeSetting setting, AnyCallback callback)
    : Node(std::move(setting), std::move(callback)), ring_(Node::setting().queue) {}

void QueuedNode::Deliver(QueuedMessage&& message, bool reserved, std::int64_t&) noexcept {
  std::optional<QueuedMessage> dropped;  // Let go of after the lock.
  bool wake = false;
  {
    const std::scoped_lock lock(mutex_);
    if (reserved) ring_.Cancel(message.bytes);
    if (closed_) return;
    // Single writers under the lock; the atomics are for readers outside it.
    Add(received_, std::uint64_t{1}, Writers::kOne);
    if (!lossless()) message.credit.reset();
    dropped = ring_.Push(std::move(message));
    if (dropped) Add(dropped_, std::uint64_t{1}, Writers::kOne);
    wake = NeedsWake();
  }
  if (wake) Wake();
}

bool QueuedNode::Reserve(std::size_t bytes) noexcept {
  const std::scoped_lock lock(mutex_);
  return ring_.Reserve(bytes);
}

void QueuedNode::CancelReservation(std::size_t bytes) noexcept {
  const std::scoped_lock lock(mutex_);
  ring_.Cancel(bytes);
}

void QueuedNode::Preload(std::vector<QueuedMessage> messages) {
  const std::scoped_lock lock(mutex_);
  preloaded_ = std::move(messages);
  Add(received_, std::uint64_t{preloaded_.size()}, Writers::kOne);
}

void QueuedNode::Start() {
  // One wake for each: a concurrent node runs one message per wake.
  for (;;) {
    {
      const std::scoped_lock lock(mutex_);
      if (!HasMessages() || closed_ || !NeedsWake()) return;
    }
    Wake();
  }
}

bool QueuedNode::TakeNext(QueuedMessage& next) {
  if (closed_) return false;
  if (next_preloaded_ < preloaded_.size()) {
    next = std::move(preloaded_[next_preloaded_++]);
    return true;
  }
  if (ring_.empty()) return false;
  next = ring_.Pop();
  return true;
}

void QueuedNode::RunUnlocked(std::unique_lock<std::mutex>& lock, QueuedMessage&& next, std::int64_t& now) noexcept {
  ++running_;
  lock.unlock();
  next.credit.reset();
  if (lossless()) NotifyRoom();
  // Concurrent callbacks of one node share its counters.
  const Writers writers = setting().invoke == Invoke::kSerial ? Writers::kOne : Writers::kMany;
  Run(next.message, next.info, stats_, writers, now);
  next.message.reset();
  lock.lock();
  --running_;
  if (closed_ || watchers_ > 0) changed_.notify_all();
  if (closed_) DropCallbackOnce(lock);
}

// Outside the lock: what the callback captured may be a handle of this very node. It counts as running meanwhile, so
// that who waits for the node also waits for this.
void QueuedNode::DropCallbackOnce(std::unique_lock<std::mutex>& lock) noexcept {
  if (callback_dropped_ || running_ > 0) return;
  callback_dropped_ = true;
  ++running_;
  lock.unlock();
  DropCallback();
  lock.lock();
  --running_;
  changed_.notify_all();
}

void QueuedNode::Close(bool wait) {
  std::vector<QueuedMessage> discarded;  // Let go of after the lock.
  std::unique_lock lock(mutex_);
  closed_ = true;
  while (!ring_.empty()) discarded.push_back(ring_.Pop());
  discarded.insert(discarded.end(), std::make_move_iterator(preloaded_.begin()),
                   std::make_move_iterator(preloaded_.end()));
  preloaded_.clear();
  next_preloaded_ = 0;
  changed_.notify_all();
  lock.unlock();
  NotifyRoom();  // Publishers need not wait for a node that is going.
  lock.lock();
  if (wait) changed_.wait(lock, [this] { return running_ == 0; });
  DropCallbackOnce(lock);
}

bool QueuedNode::WaitIdle(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  ++watchers_;
  const bool idle =
      changed_.wait_until(lock, deadline, [this] { return closed_ || (running_ == 0 && !HasMessages()); });
  --watchers_;
  return idle;
}

std::size_t QueuedNode::QueuedNow() const {
  const std::scoped_lock lock(mutex_);
  return QueuedHere();
}

}  // namespace hgros
