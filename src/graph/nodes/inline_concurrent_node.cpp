#include "graph/nodes/inline_concurrent_node.hpp"

#include <utility>

#include "hgros/clock/time.hpp"

namespace hgros {

InlineConcurrentNode::InlineConcurrentNode(NodeSetting setting, AnyCallback callback)
    : Node(std::move(setting), std::move(callback)) {}

void InlineConcurrentNode::Deliver(const Delivery& delivery, bool, std::int64_t& now) noexcept {
  Shard& shard = shards_[ThisThreadShard()];
  shard.running.fetch_add(1, std::memory_order_seq_cst);
  if (!closed_.load(std::memory_order_seq_cst)) {
    Run(delivery.message, delivery.info, shard.stats, Writers::kMany, now);
  }
  shard.running.fetch_sub(1, std::memory_order_seq_cst);
  if (watchers_.load(std::memory_order_seq_cst) == 0 && !closed_.load(std::memory_order_seq_cst)) return;
  std::unique_lock lock(mutex_);
  idle_.notify_all();
  if (closed_ && Idle()) DestroyCallbackOnce(true, lock, idle_);
}

void InlineConcurrentNode::Preload(std::vector<QueuedMessage> messages) { preloaded_ = std::move(messages); }

void InlineConcurrentNode::Start() {
  std::int64_t now = MonotonicNow();
  for (QueuedMessage& message : std::exchange(preloaded_, {})) {
    Deliver({message.message, message.info, message.credit, message.bytes, true}, false, now);
  }
}

int InlineConcurrentNode::Running() const noexcept {
  int running = 0;
  for (const Shard& shard : shards_) running += shard.running.load(std::memory_order_seq_cst);
  return running;
}

void InlineConcurrentNode::Close(bool wait) {
  closed_.store(true, std::memory_order_seq_cst);
  std::unique_lock lock(mutex_);
  if (wait) idle_.wait(lock, [this] { return Idle() && !destroying_callback(); });
  if (Idle()) DestroyCallbackOnce(false, lock, idle_);
}

bool InlineConcurrentNode::WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) {
  watchers_.fetch_add(1, std::memory_order_seq_cst);
  std::unique_lock lock(mutex_);
  const bool idle = idle_.wait_until(lock, deadline, [this, own] { return Running() <= own; });
  watchers_.fetch_sub(1, std::memory_order_seq_cst);
  return idle;
}

void InlineConcurrentNode::AddStats(NodeSnapshot& snapshot) const {
  for (const Shard& shard : shards_) {
    snapshot.run += shard.stats.run.load(std::memory_order_relaxed);
    snapshot.failed += shard.stats.failed.load(std::memory_order_relaxed);
    shard.stats.queue_wait.AddTo(snapshot.queue_wait);
    shard.stats.run_time.AddTo(snapshot.run_time);
    shard.stats.ages.AddTo(snapshot.ages);
  }
  snapshot.received = snapshot.run;
}

}  // namespace hgros
