#include "graph/nodes/queued_node.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "graph/channel/message_numbers.hpp"
#include "graph/nodes/spin_then_lock.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

QueuedNode::QueuedNode(NodeSetting setting, AnyCallback callback)
    : Node(std::move(setting), std::move(callback)), ring_(Node::setting().queue) {}

void QueuedNode::Deliver(const Delivery& delivery, bool reserved, std::int64_t&) noexcept {
  std::optional<QueuedMessage> dropped;  // Destroyed after the lock.
  bool wake = false;
  {
    std::unique_lock lock(mutex_, std::defer_lock);
    SpinThenLock(lock);
    if (reserved) ring_.Cancel(delivery.bytes);
    if (closed_) [[unlikely]] {
      const bool missed = std::exchange(refused_, false);
      lock.unlock();
      if (missed) NotifyRoom();  // A publisher waits for the room that was reserved.
      return;
    }
    // Single writers under the lock; the atomics are for readers outside it.
    Add(received_, std::uint64_t{1}, Writers::kOne);
    dropped = ring_.Push(delivery);
    if (dropped) Add(dropped_, std::uint64_t{1}, Writers::kMany);  // See CountDropped().
    wake = !suspended_ && NeedsWake();
  }
  if (wake) Wake();
  if (dropped) [[unlikely]]
    SayDropped();
}

// One lock instead of two in Reserve() and Deliver().
bool QueuedNode::TryDeliverSole(const SoleOffer& sole, AnyMessage& message, MessageInfo& info, std::int64_t&) noexcept {
  const std::shared_ptr<const void> no_credit;
  bool wake = false;
  {
    std::unique_lock lock(mutex_, std::defer_lock);
    SpinThenLock(lock);
    if (!closed_ && !ReserveHere(sole.bytes)) return false;
    message = sole.offer.take(sole.offer.context);
    sole.numbers.Number(info);
    if (closed_) return true;
    ring_.Cancel(sole.bytes);
    Add(received_, std::uint64_t{1}, Writers::kOne);
    ring_.Push({message, info, no_credit, sole.bytes, sole.last});
    wake = !suspended_ && NeedsWake();
  }
  if (wake) Wake();
  return true;
}

// For a node that batches, the exact number of unstarted messages is in a cache line of the running thread, so it is
// read only if it matters.
bool QueuedNode::ReserveHere(std::size_t bytes) noexcept {
  const bool roughly = Batches() && ring_.HasRoom(batched_);
  const std::size_t popped = roughly ? batched_ : unstarted_.load(std::memory_order_seq_cst);
  if (ring_.Reserve(bytes, popped)) return true;
  refused_ = true;
  return false;
}

bool QueuedNode::Reserve(std::size_t bytes) noexcept {
  std::unique_lock lock(mutex_, std::defer_lock);
  SpinThenLock(lock);
  return ReserveHere(bytes);
}

bool QueuedNode::CancelReservation(std::size_t bytes) noexcept {
  const std::scoped_lock lock(mutex_);
  ring_.Cancel(bytes);
  return std::exchange(refused_, false);
}

void QueuedNode::Preload(std::vector<QueuedMessage> messages) {
  const std::scoped_lock lock(mutex_);
  front_ = std::move(messages);
  Add(received_, std::uint64_t{front_.size()}, Writers::kOne);
}

void QueuedNode::CallWithoutMessage(const MessageInfo& info) {
  bool wake = false;
  {
    const std::scoped_lock lock(mutex_);
    if (closed_) return;
    if (2 * next_in_front_ >= front_.size()) {
      front_.erase(front_.begin(), front_.begin() + static_cast<std::ptrdiff_t>(next_in_front_));
      next_in_front_ = 0;
    }
    front_.push_back({nullptr, info, nullptr});
    wake = NeedsWake();
  }
  if (wake) Wake();
}

void QueuedNode::WakeForWaiting() {
  std::size_t most = 1;
  for (std::size_t i = 0; i < most; ++i) {
    {
      const std::scoped_lock lock(mutex_);
      if (!MayRun() || closed_ || !NeedsWake()) return;
      if (i == 0 && setting().invoke == Invoke::kConcurrent) most = RunnableHere();
    }
    Wake();
  }
}

void QueuedNode::Suspend(bool suspended) {
  {
    const std::scoped_lock lock(mutex_);
    suspended_ = suspended;
  }
  if (!suspended) WakeForWaiting();
}

QueuedMessage QueuedNode::PopNext() {
  if (QueuedInFront() > 0) return std::move(front_[next_in_front_++]);
  return ring_.Pop();
}

// Three kinds of nodes take one message at a time. A keep-last ring must be able to drop its oldest message until the
// callback begins. Concurrent callbacks share the ring. And bytes are not counted outside the ring.
bool QueuedNode::Batches() const noexcept {
  return lossless() && setting().invoke == Invoke::kSerial && setting().queue.limit_bytes() == Queue::kUnlimitedBytes;
}

void QueuedNode::RunTaken(QueuedMessage& message, Writers writers, std::int64_t& now) noexcept {
  message.credit.reset();
  unstarted_.fetch_sub(1, std::memory_order_seq_cst);  // Before NotifyRoom() checks for waiting publishers.
  if (!closed_) {
    if (lossless()) NotifyRoom();
    Run(message.message, message.info, stats_, writers, now);
  }
  message.message.reset();
}

void QueuedNode::RunSome(std::unique_lock<std::mutex>& lock, std::size_t most, std::int64_t& now,
                         std::int64_t until_ns) noexcept {
  const bool batches = Batches();
  for (std::size_t taken = 0; taken < most && now < until_ns && !closed_;) {
    if (!MayRun()) {
      if (suspended_ || taken < kFlood || !MoreCame(lock)) return;
      now = MonotonicNow();
    }
    const std::int64_t begun = now;
    const std::size_t before = taken;
    if (batches && !slow_ && QueuedInFront() == 0) {
      std::unique_ptr<MessageRing::Block> block = ring_.PopBlock();
      taken += block->messages().size();
      RunUnlocked(block->messages(), lock, now);
      ring_.GiveBack(std::move(block));
    } else {
      QueuedMessage one = PopNext();
      ++taken;
      RunUnlocked({&one, 1}, lock, now);
    }
    slow_ = (now - begun) * static_cast<std::int64_t>(MessageRing::Block::kSize) >
            kTurnNs * static_cast<std::int64_t>(taken - before);
    if (closed_ || watchers_ > 0) changed_.notify_all();
    if (closed_ && running_ == 0) DestroyCallbackOnce(true, lock, changed_);
  }
}

// Messages arrive in quick succession: waiting a moment for the next ones costs less than a wake-up for each, and lets
// the publisher have the lock.
bool QueuedNode::MoreCame(std::unique_lock<std::mutex>& lock) noexcept {
  lock.unlock();
  for (int i = 0; i < kPauses; ++i) PauseBriefly();
  SpinThenLock(lock);
  return MayRun();
}

void QueuedNode::RunUnlocked(std::span<QueuedMessage> batch, std::unique_lock<std::mutex>& lock,
                             std::int64_t& now) noexcept {
  // Concurrent callbacks of one node share its counters.
  const Writers writers = setting().invoke == Invoke::kSerial ? Writers::kOne : Writers::kMany;
  unstarted_.fetch_add(batch.size(), std::memory_order_relaxed);
  batched_ = batch.size();
  ++running_;
  lock.unlock();
  for (QueuedMessage& message : batch) RunTaken(message, writers, now);
  SpinThenLock(lock);
  batched_ = 0;
  --running_;
}

void QueuedNode::Close(bool wait) {
  std::vector<QueuedMessage> discarded;  // Destroyed after the lock.
  std::unique_lock lock(mutex_);
  closed_ = true;
  while (!ring_.empty()) discarded.push_back(ring_.Pop());
  discarded.insert(discarded.end(), std::make_move_iterator(front_.begin()), std::make_move_iterator(front_.end()));
  front_.clear();
  next_in_front_ = 0;
  changed_.notify_all();
  lock.unlock();
  NotifyRoom();  // Publishers must not wait for a closed node.
  lock.lock();
  if (wait) changed_.wait(lock, [this] { return running_ == 0 && !destroying_callback(); });
  if (running_ == 0) DestroyCallbackOnce(false, lock, changed_);
}

bool QueuedNode::WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  ++watchers_;
  const bool idle = changed_.wait_until(lock, deadline, [this, own] {
    return running_ <= own && (own > 0 || !destroying_callback()) && (closed_ || !HasMessages() || !RunsByItself());
  });
  --watchers_;
  return idle;
}

std::size_t QueuedNode::QueuedNow() const {
  const std::scoped_lock lock(mutex_);
  return QueuedHere() + unstarted_.load(std::memory_order_relaxed);
}

}  // namespace hgros
