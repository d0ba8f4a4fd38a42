#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>

#include "hgros/base/publish_status.hpp"

namespace hgros {

// Publishers wait here while a lossless subscriber of their channel has no room.
//
// Thread safety: all functions. Invariants: a Notify() after a refused attempt is never missed.
class RoomSignal {
 public:
  // Somebody may have room again. Costs one load if no publisher waits.
  void Notify() noexcept {
    if (waiters_.load(std::memory_order_seq_cst) == 0) return;
    {
      const std::scoped_lock lock(mutex_);
      ++changes_;
    }
    changed_.notify_all();
  }

  // Calls `attempt`, and again after each Notify(), until it returns anything except kFull. Returns that, kStopped or
  // kTimedOut.
  template <class Attempt>
  PublishStatus Retry(Attempt attempt, std::chrono::steady_clock::time_point deadline, const std::stop_token& stop) {
    PublishStatus status = PublishStatus::kFull;
    waiters_.fetch_add(1, std::memory_order_seq_cst);
    for (;;) {
      std::uint64_t seen = 0;
      {
        const std::scoped_lock lock(mutex_);
        seen = changes_;
      }
      status = attempt();
      if (status != PublishStatus::kFull) break;
      std::unique_lock lock(mutex_);
      const bool changed = changed_.wait_until(lock, stop, deadline, [&] { return changes_ != seen; });
      if (changed && !stop.stop_requested() && std::chrono::steady_clock::now() < deadline) continue;
      status = stop.stop_requested() ? PublishStatus::kStopped : PublishStatus::kTimedOut;
      break;
    }
    waiters_.fetch_sub(1, std::memory_order_seq_cst);
    return status;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::uint64_t changes_ = 0;
  alignas(64) std::atomic<int> waiters_{0};  // Read for every message that a lossless node runs.
};

}  // namespace hgros
