#include "hgros/base/histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace hgros {

// Values below 8 have a bucket each; above, the position of the top bit picks the octave and the next three bits
// the bucket within it.
std::size_t LogHistogram::BucketOf(std::int64_t nanoseconds) noexcept {
  if (nanoseconds <= 0) return 0;
  const auto value = static_cast<std::uint64_t>(nanoseconds);
  if (value < kBucketsPerOctave) return static_cast<std::size_t>(value);
  const auto top = static_cast<std::size_t>(std::bit_width(value)) - 1;
  const auto within = static_cast<std::size_t>((value >> (top - 3)) & 7U);
  return std::min((top - 2) * kBucketsPerOctave + within, kBucketCount - 1);
}

std::int64_t LogHistogram::UpperEdge(std::size_t bucket) noexcept {
  const std::size_t next = bucket + 1;
  if (next <= kBucketsPerOctave) return static_cast<std::int64_t>(next);
  const std::size_t octave = next / kBucketsPerOctave;
  const std::size_t within = next % kBucketsPerOctave;
  return static_cast<std::int64_t>((kBucketsPerOctave + within) << (octave - 1));
}

void LogHistogram::Merge(const LogHistogram& other) noexcept {
  for (std::size_t i = 0; i < kBucketCount; ++i) buckets_[i] += other.buckets_[i];
  count_ += other.count_;
  sum_ += other.sum_;
  max_ = std::max(max_, other.max_);
}

std::int64_t LogHistogram::Quantile(double q) const noexcept {
  if (count_ == 0) return 0;
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(count_);
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(wanted)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i + 1 < kBucketCount; ++i) {  // the last bucket ends at the maximum
    seen += buckets_[i];
    if (seen >= rank) return std::min(UpperEdge(i), max_);
  }
  return max_;
}

}  // namespace hgros
