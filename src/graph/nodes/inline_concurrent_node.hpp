#pragma once

#include <array>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "graph/nodes/node.hpp"

namespace hgros {

// Runs its callback in the delivering threads, any number at once, and never queues. Counters are spread over cache
// lines so that delivering threads do not slow each other down.
//
// Invariants: a thread raises its shard's count before it looks at closed_; Close() sets closed_ before it reads the
// counts (both sequentially consistent), so no callback starts unseen.
class InlineConcurrentNode final : public Node {
 public:
  InlineConcurrentNode(NodeSetting setting, AnyCallback callback);

  void Deliver(const Delivery& delivery, bool reserved, std::int64_t& now) noexcept override;
  bool Reserve(std::size_t) noexcept override { return true; }
  bool CancelReservation(std::size_t) noexcept override { return false; }
  void Preload(std::vector<QueuedMessage> messages) override;
  void Start() override;
  void Close(bool wait) override;
  bool WaitForOthers(int own, std::chrono::steady_clock::time_point deadline) override;

 protected:
  std::size_t QueuedNow() const override { return 0; }
  void AddStats(NodeSnapshot& snapshot) const override;

 private:
  struct alignas(64) Shard {
    std::atomic<int> running{0};
    NodeStats stats;
  };

  [[nodiscard]] int Running() const noexcept;
  [[nodiscard]] bool Idle() const noexcept { return Running() == 0; }

  std::array<Shard, kShards> shards_;
  std::atomic<bool> closed_{false};
  std::atomic<int> watchers_{0};
  std::mutex mutex_;
  std::condition_variable idle_;
  std::vector<QueuedMessage> preloaded_;
};

}  // namespace hgros
