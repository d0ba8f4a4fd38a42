#pragma once

#include <condition_variable>
#include <mutex>
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

  void Deliver(QueuedMessage&& message, bool reserved, std::int64_t& now) noexcept override;
  bool Reserve(std::size_t bytes) noexcept override;
  void CancelReservation(std::size_t bytes) noexcept override;
  void Preload(std::vector<QueuedMessage> messages) override;
  void Start() override;
  void Close(bool wait) override;
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) override;

 protected:
  // A message has come and the lock is held; returns true if Wake() is to be called once it is released.
  virtual bool NeedsWake() = 0;
  virtual void Wake() noexcept = 0;

  std::size_t QueuedNow() const override;

  // Takes the oldest message, latched ones first; `lock` is held. False if there is none or the node is closed.
  bool TakeNext(QueuedMessage& next);
  // Runs the callback with `lock` released meanwhile.
  void RunUnlocked(std::unique_lock<std::mutex>& lock, QueuedMessage&& next, std::int64_t& now) noexcept;
  // Waiting messages; the lock is held.
  [[nodiscard]] std::size_t QueuedHere() const noexcept { return ring_.size() + preloaded_.size() - next_preloaded_; }
  [[nodiscard]] bool HasMessages() const noexcept { return QueuedHere() > 0; }

  mutable std::mutex mutex_;
  std::condition_variable changed_;  // running_ fell, closed_ was set, or a message came (dedicated threads)
  bool closed_ = false;
  int running_ = 0;

 private:
  void DropCallbackOnce(std::unique_lock<std::mutex>& lock) noexcept;

  MessageRing ring_;
  std::vector<QueuedMessage> preloaded_;
  std::size_t next_preloaded_ = 0;
  int watchers_ = 0;
  bool callback_dropped_ = false;
};

}  // namespace hgros
