#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "graph/nodes/callback_guard.hpp"
#include "graph/nodes/node_setting.hpp"
#include "graph/nodes/node_stats.hpp"
#include "graph/nodes/queued_message.hpp"
#include "hgros/base/log.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/publisher.hpp"
#include "hgros/graph/snapshot.hpp"
#include "hgros/internal/graph/callback.hpp"

namespace hgros {

class MessageNumbers;

// A subscription's callback and its queue; one derived class for each way of running it.
//
// Thread safety: all public functions may be called from any thread at any time.
// Invariants: after Close(true) has returned outside the node's own callbacks, the callback never runs again and its
// captures are destroyed. A serial node runs at most one callback at a time.
class Node : public std::enable_shared_from_this<Node> {
 public:
  Node(NodeSetting setting, AnyCallback callback);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  // Delivers a message. `now` is the current time (CLOCK_MONOTONIC, ns); a node that runs its callback at once sets it
  // to the time after that. `reserved`: room was reserved with Reserve().
  virtual void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept = 0;

  // For the only lossless node of a channel: reserves room, takes the message and its number and delivers it. Either
  // all of this happens or nothing. `message` is set so that it can be delivered to the other nodes, too.
  struct SoleOffer {
    const MessageOffer& offer;
    MessageNumbers& numbers;
    std::size_t bytes;
    bool last;  // The same as in Delivery.
  };
  [[nodiscard]] virtual bool TryDeliverSole(const SoleOffer& sole, AnyMessage& message, MessageInfo& info,
                                            std::int64_t& now) noexcept;

  // Lossless nodes: reserves room for one message. False if there is none.
  [[nodiscard]] virtual bool Reserve(std::size_t bytes) noexcept = 0;
  // Releases reserved room. True if another publisher was refused since the last call. This reservation may have been
  // the only reason, so waiting publishers must try again.
  [[nodiscard]] virtual bool CancelReservation(std::size_t bytes) noexcept = 0;

  // Messages that were latched before this node was added. Called once, before any Deliver().
  virtual void Preload(std::vector<QueuedMessage> messages) = 0;
  // Starts to run the preloaded messages.
  virtual void Start() = 0;

  // No callback starts after this. With `wait` it waits for the running ones.
  virtual void Close(bool wait) = 0;
  // Waits until no message is queued and no callback runs; false if the deadline came first.
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) { return WaitForOthers(0, deadline); }
  // The same, except for `own` callbacks, which the calling thread itself runs.
  virtual bool WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) = 0;

  // A delivery would have to wake a worker, so the delivering thread should run the node itself: see ReadyNodeSlot.
  [[nodiscard]] virtual bool WouldWakeWorker() const noexcept { return false; }

  // The callback only hands messages to another thread, which counts what becomes of them: see HandedOver.
  void HandOver() noexcept { handed_over_.store(true, std::memory_order_relaxed); }
  void CountDropped() noexcept;
  void CountRefused() noexcept { Add(stats_.refused, std::uint64_t{1}, Writers::kMany); }
  void CountRun(const MessageInfo& info, std::int64_t start, std::int64_t end, bool failed) noexcept;

  // From now on messages may be of another type than the callback takes.
  void ExpectTwoForms() noexcept { two_forms_.store(true, std::memory_order_relaxed); }
  // Messages of another type have ended, and none comes until ExpectTwoForms() is called again.
  void ExpectOneForm() noexcept { two_forms_.store(false, std::memory_order_relaxed); }
  [[nodiscard]] bool expects_two_forms() const noexcept { return two_forms_.load(std::memory_order_relaxed); }

  // For a node whose callback the program runs: runs it with up to `most` messages on this thread and returns how many;
  // and a descriptor that is readable while messages wait or once the node is closed.
  virtual std::size_t RunWaiting(std::size_t /*most*/) noexcept { return 0; }
  [[nodiscard]] virtual int descriptor() const noexcept { return -1; }

  // See NodeQueue. A node without a queue does nothing.
  [[nodiscard]] virtual bool has_queue() const noexcept { return false; }
  virtual void Suspend(bool /*suspended*/) {}
  virtual void CallWithoutMessage(const MessageInfo& /*info*/) {}

  // Waits after Close() for the end of the node's own thread, if it has one; does nothing on that thread.
  virtual void JoinThread() {}

  [[nodiscard]] NodeSnapshot Snapshot() const;
  [[nodiscard]] const NodeSetting& setting() const noexcept { return setting_; }
  [[nodiscard]] bool lossless() const noexcept { return setting_.queue.lossless(); }

 protected:
  [[nodiscard]] virtual std::size_t QueuedNow() const = 0;
  // Adds the counters of running callbacks. The base has one set of them, a derived class may have several.
  virtual void AddStats(NodeSnapshot& snapshot) const;

  // Calls the callback with the message converted to its type.
  void CallInForm(const AnyMessage& message, const MessageInfo& info);
  // Runs the callback; counts and logs exceptions. `now` as in Deliver().
  void Run(const AnyMessage& message, const MessageInfo& info, NodeStats& stats, Writers writers,
           std::int64_t& now) noexcept;
  // For a closed node without running callbacks: see CallbackGuard. `after_run`: this thread has just run one.
  void DestroyCallbackOnce(bool after_run, std::unique_lock<std::mutex>& lock,
                           std::condition_variable& changed) noexcept {
    callback_.DestroyOnce(after_run ? setting_.graph : nullptr, this, lock, changed);
  }
  [[nodiscard]] bool destroying_callback() const noexcept { return callback_.destroying(); }
  void NotifyRoom() const noexcept;
  // Logs the first drop of a node that wants more than the newest message. Call it without the node's lock.
  void SayDropped() noexcept;

 private:
  // Counts a callback with the message that has ended.
  void CountEnded(const MessageInfo& info, std::int64_t start, std::int64_t end, NodeStats& stats, Writers writers);

  // Delivering threads write the last group, running threads the one before it, and both read the first: each has
  // cache lines of its own.
  NodeSetting setting_;
  CallbackGuard callback_;
  std::atomic<bool> two_forms_{false};
  std::atomic<bool> handed_over_{false};
  std::atomic<bool> said_dropped_{false};

 protected:
  NodeStats stats_;
  alignas(64) std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace hgros
