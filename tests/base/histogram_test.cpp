#include "hgros/base/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/seed.hpp"

namespace hgros {
namespace {

constexpr std::int64_t kLargestExact = std::int64_t{1} << 44;  // ns; larger values go to the last bucket

/// The exact definition that the histogram approximates: sorts all values and takes the element of that rank.
class SortedVector {
 public:
  void Record(std::int64_t value) { values_.push_back(std::max<std::int64_t>(value, 0)); }

  std::int64_t Quantile(double q) {
    if (values_.empty()) return 0;
    std::sort(values_.begin(), values_.end());
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values_.size())));
    return values_[std::max<std::size_t>(rank, 1) - 1];
  }
  double Mean() const {
    double sum = 0;
    for (const std::int64_t value : values_) sum += static_cast<double>(value);
    return values_.empty() ? 0 : sum / static_cast<double>(values_.size());
  }
  std::size_t size() const { return values_.size(); }

 private:
  std::vector<std::int64_t> values_;
};

std::int64_t RandomDuration(std::mt19937_64& random) {
  const auto bits = std::uniform_int_distribution<int>(0, 43)(random);
  return static_cast<std::int64_t>(random() >> (63 - bits)) - 1;  // -1: two clock readings in the wrong order
}

TEST(LogHistogram, IsEmptyAtFirst) {
  const LogHistogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.max_ns(), 0);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
  EXPECT_EQ(histogram.Quantile(0.5), 0);
}

TEST(LogHistogram, EveryBucketEndsWhereTheNextBegins) {
  for (std::size_t bucket = 0; bucket < LogHistogram::kBucketCount; ++bucket) {
    const std::int64_t edge = LogHistogram::UpperEdge(bucket);
    ASSERT_EQ(LogHistogram::BucketOf(edge - 1), bucket);
    ASSERT_EQ(LogHistogram::BucketOf(edge), std::min(bucket + 1, LogHistogram::kBucketCount - 1));
  }
}

TEST(LogHistogram, CountsValuesOutsideTheRangeInTheOutermostBuckets) {
  EXPECT_EQ(LogHistogram::BucketOf(std::numeric_limits<std::int64_t>::min()), 0U);
  EXPECT_EQ(LogHistogram::BucketOf(-1), 0U);
  EXPECT_EQ(LogHistogram::BucketOf(kLargestExact), LogHistogram::kBucketCount - 1);
  EXPECT_EQ(LogHistogram::BucketOf(std::numeric_limits<std::int64_t>::max()), LogHistogram::kBucketCount - 1);
}

TEST(LogHistogram, ReportsTheMaximumEvenPastTheLastBucket) {
  LogHistogram histogram;
  histogram.Record(5 * kLargestExact);
  EXPECT_EQ(histogram.Quantile(1.0), 5 * kLargestExact);
  EXPECT_EQ(histogram.max_ns(), 5 * kLargestExact);
}

TEST(LogHistogram, CountsNegativeDurationsAsZero) {
  LogHistogram histogram;
  histogram.Record(-1'000);
  EXPECT_EQ(histogram.count(), 1U);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
  EXPECT_EQ(histogram.Quantile(1.0), 0);
}

TEST(LogHistogram, AcceptsAnyQuantile) {
  LogHistogram histogram;
  histogram.Record(100);
  for (const double q : {-1.0, 0.0, 0.5, 1.0, 7.0}) EXPECT_EQ(histogram.Quantile(q), 100) << q;
}

TEST(LogHistogram, AgreesWithASortedVector) {
  std::mt19937_64 random(test::Seed());
  for (int round = 0; round < 50; ++round) {
    LogHistogram histogram;
    SortedVector model;
    const auto records = std::uniform_int_distribution<int>(1, 2'000)(random);
    for (int i = 0; i < records; ++i) {
      const std::int64_t value = RandomDuration(random);
      histogram.Record(value);
      model.Record(value);
    }
    ASSERT_EQ(histogram.count(), model.size());
    ASSERT_NEAR(histogram.mean_ns(), model.Mean(), 1e-9 * model.Mean());
    std::int64_t previous = 0;
    for (const double q : {0.0, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      const std::int64_t exact = model.Quantile(q);
      const std::int64_t read = histogram.Quantile(q);
      ASSERT_GE(read, exact) << "q " << q;
      ASSERT_LE(read, exact + std::max<std::int64_t>(1, exact / 8 + 1)) << "q " << q;
      ASSERT_GE(read, previous) << "q " << q;
      previous = read;
    }
  }
}

TEST(LogHistogram, MergeEqualsOneHistogramOfAllValues) {
  std::mt19937_64 random(test::Seed());
  LogHistogram parts[3];
  LogHistogram whole;
  for (int i = 0; i < 5'000; ++i) {
    const std::int64_t value = RandomDuration(random);
    parts[random() % 3].Record(value);
    whole.Record(value);
  }
  LogHistogram merged;
  for (const LogHistogram& part : parts) merged.Merge(part);
  EXPECT_EQ(merged.count(), whole.count());
  EXPECT_EQ(merged.max_ns(), whole.max_ns());
  EXPECT_EQ(merged.mean_ns(), whole.mean_ns());
  for (double q = 0; q <= 1; q += 0.01) ASSERT_EQ(merged.Quantile(q), whole.Quantile(q)) << "q " << q;
}

}  // namespace
}  // namespace hgros
