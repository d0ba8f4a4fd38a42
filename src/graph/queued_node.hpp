#pragma once

#include <condition_variable>
#include <mutex>
#include <span>
#include <vector>

#include "graph/message_ring.hpp"
#include "graph/node.hpp"

namespace hgros {

// A node whose messages wait in its ring for a thread of its executor.
//
// Thread safety: mutex_ guards all members below it; callbacks run outside it.
// Invariants: running_ counts the callbacks in flight; once closed_ is set none starts.
class QueuedNode : public Node {
 public:
  QueuedNode(NodeSetting setting, AnyCallback callback);

  void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept override;
  bool Take(const SoleOffer& sole, AnyMessage& message, MessageInfo& info, std::int64_t& now) noexcept override;
  bool Reserve(std::size_t bytes) noexcept override;
  bool CancelReservation(std::size_t bytes) noexcept override;
  void Preload(std::vector<QueuedMessage> messages) override;
  void Start() override;
  void Close(bool wait) override;
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) override;

 protected:
  // A message has come and the lock is held; returns true if Wake() is to be called once it is released.
  virtual bool NeedsWake() = 0;
  virtual void Wake() noexcept = 0;

  std::size_t QueuedNow() const override;

  // Runs `most` waiting messages (or a few more), the oldest first and latched ones before all, with `lock` released
  // while callbacks run. Returns at once if there is none or the node is closed.
  void RunSome(std::unique_lock<std::mutex>& lock, std::size_t most, std::int64_t& now) noexcept;
  // Waiting messages; the lock is held.
  [[nodiscard]] std::size_t QueuedHere() const noexcept { return ring_.size() + preloaded_.size() - next_preloaded_; }
  [[nodiscard]] bool HasMessages() const noexcept { return QueuedHere() > 0; }

  alignas(64) mutable std::mutex mutex_;
  std::condition_variable changed_;  // running_ fell, or closed_ was set
  int running_ = 0;

 private:
  static constexpr std::size_t kFlood = 16;  // So many messages run in one go are a flood.
  static constexpr int kPauses = 400;        // A few microseconds.

  // Takes room; the lock is held.
  [[nodiscard]] bool ReserveHere(std::size_t bytes) noexcept;
  // Whether a block of messages may be taken out at once, which costs one lock instead of one for each.
  [[nodiscard]] bool Batches() const noexcept;
  // The oldest message; there must be one. The lock is held.
  QueuedMessage TakeNext();
  // Waits a moment for messages, with the lock released; whether there are any now.
  [[nodiscard]] bool MoreCame(std::unique_lock<std::mutex>& lock) noexcept;
  // Runs messages that were taken out; the lock is released meanwhile.
  void RunUnlocked(std::span<QueuedMessage> batch, std::unique_lock<std::mutex>& lock, std::int64_t& now) noexcept;
  void RunTaken(QueuedMessage& message, Writers writers, std::int64_t& now) noexcept;
  void DropCallbackOnce(std::unique_lock<std::mutex>& lock) noexcept;

  MessageRing ring_;
  bool refused_ = false;  // A reservation, since one was last given back.
  std::vector<QueuedMessage> preloaded_;
  std::size_t next_preloaded_ = 0;
  std::size_t batched_ = 0;  // Messages in the batch that runs now, if nodes of this kind batch.
  int watchers_ = 0;
  bool callback_dropped_ = false;

  // The running thread's own cache line.
  alignas(64) std::atomic<std::size_t> unstarted_{0};  // Taken out, callback not begun: still queued.

 protected:
  alignas(64) std::atomic<bool> closed_{false};  // Set under the lock; read without it between callbacks.
};

}  // namespace hgros
