#pragma once

#include <atomic>
#include <cstdint>

namespace hgros::bench {

/// A number that only grows and that threads of several processes can wait for. All zeroes is the initial state.
///
/// Thread safety: lives in memory that the processes share; every function may be called by any of them.
class SharedCounter {
 public:
  [[nodiscard]] std::uint32_t Get() const { return value_.load(std::memory_order_acquire); }
  /// Adds and wakes who waits.
  void Add(std::uint32_t count);
  /// True once the number is at least `value`; false if it is not within `limit_ns`.
  bool AwaitAtLeast(std::uint32_t value, std::int64_t limit_ns);

 private:
  std::atomic<std::uint32_t> value_;
  std::atomic<std::uint32_t> waiting_;  ///< How many sleep; who adds leaves the system call out if nobody does.
};

}  // namespace hgros::bench
