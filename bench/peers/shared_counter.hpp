#pragma once

#include <atomic>
#include <cstdint>

namespace hgros::bench {

/// A number that only grows. Threads of several processes can wait for it. All zeroes is the initial state.
///
/// Thread safety: lives in memory that the processes share. All functions are thread-safe, across processes as well.
class SharedCounter {
 public:
  [[nodiscard]] std::uint32_t Get() const { return value_.load(std::memory_order_acquire); }
  /// Adds, and wakes the waiting threads.
  void Add(std::uint32_t count);
  /// True once the number is at least `value`; false if it is not within `limit_ns`.
  bool AwaitAtLeast(std::uint32_t value, std::int64_t limit_ns);

 private:
  std::atomic<std::uint32_t> value_;
  std::atomic<std::uint32_t> waiting_;  ///< Number of sleeping threads; at 0, Add makes no system call.
};

}  // namespace hgros::bench
