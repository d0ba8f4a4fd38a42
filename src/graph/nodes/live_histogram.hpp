#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hgros/base/histogram.hpp"

namespace hgros {

// Adds without a locked instruction, for values that only one thread writes at a time. Readers never see a
// half-written value.
enum class Writers { kOne, kMany };

template <class T>
void Add(std::atomic<T>& counter, T amount, Writers writers) noexcept {
  if (writers == Writers::kOne) {
    counter.store(counter.load(std::memory_order_relaxed) + amount, std::memory_order_relaxed);
  } else {
    counter.fetch_add(amount, std::memory_order_relaxed);
  }
}

// A LogHistogram that may be read while it is written.
class LiveHistogram {
 public:
  void Record(std::int64_t nanoseconds, Writers writers) noexcept {
    Add(buckets_[LogHistogram::BucketOf(nanoseconds)], std::uint32_t{1}, writers);
    if (nanoseconds > 0) Add(sum_, static_cast<std::uint64_t>(nanoseconds), writers);
    std::int64_t max = max_.load(std::memory_order_relaxed);
    while (nanoseconds > max && !max_.compare_exchange_weak(max, nanoseconds, std::memory_order_relaxed)) {
    }
  }
  void AddTo(LogHistogram& total) const noexcept {
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      total.AddToBucket(i, buckets_[i].load(std::memory_order_relaxed));
    }
    total.AddTotals(sum_.load(std::memory_order_relaxed), max_.load(std::memory_order_relaxed));
  }

 private:
  std::array<std::atomic<std::uint32_t>, LogHistogram::kBucketCount> buckets_{};
  std::atomic<std::uint64_t> sum_{0};
  std::atomic<std::int64_t> max_{0};
};

}  // namespace hgros
