#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hgros/base/export.hpp"

namespace hgros {

/// Counts durations in logarithmic buckets, 8 per factor of two: a quantile is never below the recorded value and at
/// most 12.5 % above it (1 ns above it below 8 ns). Covers 1 ns to about 4.9 hours; values outside count in the first
/// or last bucket.
///
/// Thread safety: none; the owner guards it, or keeps one per thread and merges them.
/// Invariants: count() is the sum of all buckets; 0 <= Quantile(a) <= Quantile(b) for a <= b.
class HGROS_EXPORT LogHistogram {
 public:
  static constexpr std::size_t kBucketsPerOctave = 8;
  static constexpr std::size_t kBucketCount = 42 * kBucketsPerOctave;

  void Record(std::int64_t nanoseconds) noexcept {
    ++buckets_[BucketOf(nanoseconds)];
    ++count_;
    sum_ += nanoseconds > 0 ? static_cast<std::uint64_t>(nanoseconds) : 0;
    if (nanoseconds > max_) max_ = nanoseconds;
  }
  void Merge(const LogHistogram& other) noexcept;
  /// Adds `count` records to one bucket, for owners that count elsewhere. AddTotals() must follow.
  void AddToBucket(std::size_t bucket, std::uint32_t count) noexcept {
    buckets_[bucket] += count;
    count_ += count;
  }
  void AddTotals(std::uint64_t sum_ns, std::int64_t max_ns) noexcept {
    sum_ += sum_ns;
    if (max_ns > max_) max_ = max_ns;
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_; }
  [[nodiscard]] double mean_ns() const noexcept {
    return count_ == 0 ? 0.0 : static_cast<double>(sum_) / static_cast<double>(count_);
  }
  /// The value in ns that the share `q` (0 to 1) of the records does not exceed: the upper edge of its bucket, limited
  /// to the largest record. 0 without records.
  [[nodiscard]] std::int64_t Quantile(double q) const noexcept;

  /// The bucket of a value, and the smallest value above a bucket.
  [[nodiscard]] static std::size_t BucketOf(std::int64_t nanoseconds) noexcept;
  [[nodiscard]] static std::int64_t UpperEdge(std::size_t bucket) noexcept;

 private:
  std::array<std::uint64_t, kBucketCount> buckets_{};
  std::uint64_t count_ = 0;
  std::uint64_t sum_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace hgros
