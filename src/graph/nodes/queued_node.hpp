#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <limits>
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
  [[nodiscard]] bool has_queue() const noexcept override { return true; }
  void Suspend(bool suspended) override;
  void CallWithoutMessage(const MessageInfo& info) override;
  void Close(bool wait) override;
  bool WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) override;

 protected:
  // Called with the lock held when a message may run. True: call Wake() after the lock is released.
  virtual bool NeedsWake() = 0;
  virtual void Wake() noexcept = 0;

  std::size_t QueuedNow() const override;
  // Whether waiting messages are going to run, so that WaitForOthers() may wait for that.
  [[nodiscard]] virtual bool RunsByItself() const noexcept { return true; }

  // Runs `most` waiting messages (or a few more), those in front first, then the oldest. `lock` is released while
  // callbacks run. Returns early if no message may run, the node is closed, or a callback has ended after `until_ns`.
  void RunSome(std::unique_lock<std::mutex>& lock, std::size_t most, std::int64_t& now,
               std::int64_t until_ns = std::numeric_limits<std::int64_t>::max()) noexcept;
  // Waiting messages; the lock is held.
  [[nodiscard]] std::size_t QueuedHere() const noexcept { return ring_.size() + QueuedInFront(); }
  [[nodiscard]] bool HasMessages() const noexcept { return QueuedHere() > 0; }
  // How many of them may run; the lock is held.
  [[nodiscard]] std::size_t RunnableHere() const noexcept { return suspended_ ? QueuedInFront() : QueuedHere(); }
  [[nodiscard]] bool MayRun() const noexcept { return RunnableHere() > 0; }

  alignas(64) mutable std::mutex mutex_;
  std::condition_variable changed_;  // running_ fell, or closed_ was set
  int running_ = 0;
  bool suspended_ = false;

 private:
  static constexpr std::size_t kFlood = 16;  // This many messages in one go count as a flood.
  static constexpr int kPauses = 400;        // A few microseconds.

  [[nodiscard]] std::size_t QueuedInFront() const noexcept { return front_.size() - next_in_front_; }
  // One wake-up for each message that waits: the wake-ups of a concurrent node run on several threads.
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
  bool refused_ = false;              // A reservation was refused since one was last canceled.
  std::vector<QueuedMessage> front_;  // Latched messages, and calls without a message.
  std::size_t next_in_front_ = 0;
  std::size_t batched_ = 0;  // Messages in the running batch, for nodes that batch.
  bool slow_ = true;  // The last ones took so long that a batch would be longer than a turn; also before the first.
  int watchers_ = 0;

  // The running thread's own cache line.
  alignas(64) std::atomic<std::size_t> unstarted_{0};  // Taken out, callback not begun: still queued.

 protected:
  alignas(64) std::atomic<bool> closed_{false};  // Set under the lock; read without it between callbacks.
};

}  // namespace hgros
