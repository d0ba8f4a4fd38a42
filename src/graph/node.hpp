#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "graph/node_stats.hpp"
#include "graph/queued_message.hpp"
#include "hgros/base/log.hpp"
#include "hgros/graph/callback.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/publisher.hpp"
#include "hgros/graph/snapshot.hpp"

namespace hgros {

// What a node knows of its surroundings. `on_room` is called, outside locks, when a lossless queue has lost a message.
struct NodeSetting {
  std::string name;
  std::string channel;
  Invoke invoke = Invoke::kSerial;
  Queue queue;
  Executor executor;
  const void* graph = nullptr;
  std::shared_ptr<Log> log;
  std::function<void()> on_room;
  const TypeInfo* type = nullptr;  // What the callback takes.
  // A message as that type; null if it cannot be had. Only where the channel is used with two types.
  std::function<AnyMessage(const AnyMessage&)> in_form;
};

// A subscription's callback with its queue; one derived class per way of running it.
//
// Thread safety: all public functions may be called from any thread at any time.
// Invariants: after Close(true) has returned outside the node's own callbacks, the callback does not run and never will
// again, and what it captured is gone. A serial node runs at most one callback at a time.
class Node : public std::enable_shared_from_this<Node> {
 public:
  Node(NodeSetting setting, AnyCallback callback);
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual ~Node() = default;

  // Hands a message over. `now` is the present (CLOCK_MONOTONIC, ns); a node that runs its callback at once sets it
  // to the time at which that returned. `reserved`: room was taken by Reserve() before.
  virtual void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept = 0;

  // For a channel's only lossless node: takes room, the message and its number, all or nothing, and hands the message
  // over; `message` is set so that other nodes can have it too.
  struct SoleOffer {
    const MessageOffer& offer;
    std::atomic<std::uint64_t>& sequence;
    std::size_t bytes;
    bool last;  // As in Delivery.
  };
  [[nodiscard]] virtual bool Take(const SoleOffer& sole, AnyMessage& message, MessageInfo& info,
                                  std::int64_t& now) noexcept;

  // Lossless nodes: takes room for one message, or returns false.
  [[nodiscard]] virtual bool Reserve(std::size_t bytes) noexcept = 0;
  // Gives the room back. True if somebody was refused since the last time: perhaps only for this, so whoever waits for
  // room has to look again.
  [[nodiscard]] virtual bool CancelReservation(std::size_t bytes) noexcept = 0;

  // Messages that were latched before this node came. Called once, before any Deliver().
  virtual void Preload(std::vector<QueuedMessage> messages) = 0;
  // Begins to run what was preloaded.
  virtual void Start() = 0;

  // No callback starts after this. Waits for those in flight if `wait` says so.
  virtual void Close(bool wait) = 0;
  // Waits until nothing is queued and no callback runs; false if the deadline came first.
  virtual bool WaitIdle(std::chrono::steady_clock::time_point deadline) = 0;

  // A thread that hands it a message would better run it than wake a worker for it, see Helping.
  [[nodiscard]] virtual bool AwaitsHelp() const noexcept { return false; }

  // From now on messages may be of another type than the callback's.
  void ExpectTwoForms() noexcept { two_forms_.store(true, std::memory_order_relaxed); }

  // Waits for the end of the node's own thread, if it has one, after Close(); does nothing on that very thread.
  virtual void JoinThread() {}

  [[nodiscard]] NodeSnapshot Snapshot() const;
  [[nodiscard]] const NodeSetting& setting() const noexcept { return setting_; }
  [[nodiscard]] bool lossless() const noexcept { return setting_.queue.lossless(); }

 protected:
  [[nodiscard]] virtual std::size_t QueuedNow() const = 0;
  // Adds what was counted while running; the base has one set of counters, a derived class may have several.
  virtual void AddStats(NodeSnapshot& snapshot) const;

  // Calls it with the message as the type that it takes.
  void CallInForm(const AnyMessage& message, const MessageInfo& info);
  // Runs the callback; counts and logs what it throws. `now` as in Deliver().
  void Run(const AnyMessage& message, const MessageInfo& info, NodeStats& stats, Writers writers,
           std::int64_t& now) noexcept;
  // Destroys the callback and what it captured. Only when no callback runs and none will.
  void DropCallback() noexcept;
  void NotifyRoom() const noexcept;

  // Delivering threads write the last group, running threads the one before it, and both read the first: each has
  // cache lines of its own.
 private:
  NodeSetting setting_;
  AnyCallback callback_;
  std::atomic<bool> two_forms_{false};

 protected:
  NodeStats stats_;
  alignas(64) std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace hgros
