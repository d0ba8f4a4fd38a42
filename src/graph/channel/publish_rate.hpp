#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>

namespace hgros {

// How often a channel is published, from the numbers and times of its messages: over the last one to two seconds, or
// the last 8 to 16 messages if these are fewer.
//
// Thread safety: all functions. Messages that are published at the same time may be noted in any order.
// Invariants: mutex_ guards the marks that Hertz() reads together.
// Cost: one store and one comparison per message.
class PublishRate {
 public:
  // Times are CLOCK_MONOTONIC in ns.
  void Note(std::uint64_t sequence, std::int64_t now) noexcept {
    last_ns_.store(now, std::memory_order_relaxed);
    if (now - mark_ns_.load(std::memory_order_relaxed) >= kSpanNs) [[unlikely]]
      Mark(sequence, now);
  }
  // Messages per second; `sequence` is the last number. 0 until the second message. If no message has come for longer
  // than the measured time, it is one per time since the last.
  [[nodiscard]] double Hertz(std::uint64_t sequence, std::int64_t now) const noexcept;

 private:
  static constexpr std::int64_t kSpanNs = 1'000'000'000;
  void Mark(std::uint64_t sequence, std::int64_t now) noexcept;

  std::atomic<std::int64_t> last_ns_{0};
  std::atomic<std::int64_t> mark_ns_{-kSpanNs};  // So that the first message sets it.
  mutable std::mutex mutex_;
  std::atomic<std::uint64_t> mark_sequence_{0};  // 0: none.
  std::int64_t earlier_ns_ = 0;                  // Guarded by mutex_, like the next.
  std::uint64_t earlier_sequence_ = 0;
};

}  // namespace hgros
