#pragma once

#include <condition_variable>
#include <mutex>
#include <span>
#include <vector>

#include "graph/nodes/message_ring.hpp"
#include "graph/nodes/node.hpp"

namespace hgros {

// A node whose messages wait in its ring for a thread of its executor.
//
// Thread safety: mutex_ guards all members below it; callbacks run outside it.
// Invariants: running_ counts the running callbacks; none starts after closed_ was set.
class QueuedNode : public Node {
 public:
  QueuedNode(NodeSetting setting, AnyCallback callback);

  void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept override;
  bool TryDeliverSole(const SoleOffer& sole, AnyMessage& message, MessageInfo& info,
                      std::int64_t& now) noexcept override;
  bool Reserve(std::size_t bytes) noexcept override;
  bool CancelReservation(std::size_t bytes) noexcept override;
  void Preload(std::vector<QueuedMessage> messages) override;
  void Start() override { WakeForWaiting(); }
  bool Suspend(bool suspended) override;
  void Close(bool wait) override;
  bool WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) override;

 protected:
  // Called with the lock held when a message may run. True: call Wake() after the lock is released.
  virtual bool NeedsWake() = 0;
  virtual void Wake() noexcept = 0;

  std::size_t QueuedNow() const override;
  // Whether waiting messages are going to run, so that WaitForOthers() may wait for that.
  [[nodiscard]] virtual bool RunsByItself() const noexcept { return true; }

  // Runs `most` waiting messages (or a few more), latched ones first, then the oldest. `lock` is released while
  // callbacks run. Returns early if no message is left or the node is closed.
  void RunSome(std::unique_lock<std::mutex>& lock, std::size_t most, std::int64_t& now) noexcept;
  // Waiting messages; the lock is held.
  [[nodiscard]] std::size_t QueuedHere() const noexcept { return ring_.size() + preloaded_.size() - next_preloaded_; }
  [[nodiscard]] bool HasMessages() const noexcept { return QueuedHere() > 0; }
  // Whether a callback may begin; the lock is held.
  [[nodiscard]] bool MayRun() const noexcept { return HasMessages() && !suspended_; }

  alignas(64) mutable std::mutex mutex_;
  std::condition_variable changed_;  // running_ fell, or closed_ was set
  int running_ = 0;
  bool suspended_ = false;

 private:
  static constexpr std::size_t kFlood = 16;  // This many messages in one go count as a flood.
  static constexpr int kPauses = 400;        // A few microseconds.

  // One wake-up for each message that waits: a concurrent node runs one message per wake-up.
  void WakeForWaiting();
  // Reserves room; the lock is held.
  [[nodiscard]] bool ReserveHere(std::size_t bytes) noexcept;
  // Whether a block of messages may be popped at once, which takes one lock instead of one per message.
  [[nodiscard]] bool Batches() const noexcept;
  // Removes the oldest message; there must be one. The lock is held.
  QueuedMessage PopNext();
  // Waits a moment for messages with the lock released; returns whether there are any.
  [[nodiscard]] bool MoreCame(std::unique_lock<std::mutex>& lock) noexcept;
  // Runs popped messages with the lock released.
  void RunUnlocked(std::span<QueuedMessage> batch, std::unique_lock<std::mutex>& lock, std::int64_t& now) noexcept;
  void RunTaken(QueuedMessage& message, Writers writers, std::int64_t& now) noexcept;

  MessageRing ring_;
  bool refused_ = false;  // A reservation was refused since one was last canceled.
  std::vector<QueuedMessage> preloaded_;
  std::size_t next_preloaded_ = 0;
  std::size_t batched_ = 0;  // Messages in the running batch, for nodes that batch.
  int watchers_ = 0;

  // The running thread's own cache line.
  alignas(64) std::atomic<std::size_t> unstarted_{0};  // Taken out, callback not begun: still queued.

 protected:
  alignas(64) std::atomic<bool> closed_{false};  // Set under the lock; read without it between callbacks.
};

}  // namespace hgros
