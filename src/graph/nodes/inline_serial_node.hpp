#pragma once

#include <condition_variable>
#include <mutex>
#include <vector>

#include "graph/nodes/message_ring.hpp"
#include "graph/nodes/node.hpp"

namespace hgros {

// Runs its callback in the delivering thread, one at a time. If it is already running, another thread leaves its
// message in the ring for the running thread and does not block.
//
// Invariants: state_ is kIdle, kRunning, or kRunning with messages in the ring (kPending). Only the thread that took
// it from kIdle runs callbacks and writes stats_. The ring is empty when the state is kIdle.
class InlineSerialNode final : public Node {
 public:
  InlineSerialNode(NodeSetting setting, AnyCallback callback);

  void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept override;
  bool Reserve(std::size_t bytes) noexcept override;
  bool CancelReservation(std::size_t bytes) noexcept override;
  void Preload(std::vector<QueuedMessage> messages) override;
  void Start() override;
  void Close(bool wait) override;
  bool WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) override;

 protected:
  std::size_t QueuedNow() const override;
  void AddStats(NodeSnapshot& snapshot) const override;

 private:
  enum State : int { kIdle, kRunning, kPending };

  bool LeaveInRing(const Delivery& delivery, bool reserved);
  void RunOne(const AnyMessage& message, const MessageInfo& info, std::int64_t& now) noexcept;
  void Drain(std::int64_t& now) noexcept;
  void Finish() noexcept;
  void DestroyCallbackIfIdle(bool after_run, std::unique_lock<std::mutex>& lock) noexcept;

  std::atomic<int> state_{kIdle};
  std::atomic<bool> closed_{false};
  std::atomic<int> watchers_{0};  // Threads that wait for kIdle.
  mutable std::mutex mutex_;
  std::condition_variable idle_;
  bool refused_ = false;  // A reservation was refused since one was last canceled.
  MessageRing ring_;
  std::vector<QueuedMessage> preloaded_;
  std::atomic<std::uint64_t> left_in_ring_{0};
  std::atomic<std::uint64_t> direct_{0};  // Messages that did not go through the ring.
};

}  // namespace hgros
