#include "viewer/data/messages/number_series.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "support/seed.hpp"

namespace hgros::viewer {
namespace {

Time TimeAt(std::int64_t milliseconds) { return {milliseconds * 1'000'000}; }

TEST(NumberSeries, KeepsOnlyRecentValues) {
  NumberSeries series(std::chrono::seconds(1), 5);
  for (int i = 0; i <= 20; ++i) series.Add(TimeAt(i * 100), i);
  EXPECT_EQ(series.size(), 5U) << "the number of values is limited";
  NumberSeries more(std::chrono::seconds(1));
  for (int i = 0; i <= 20; ++i) more.Add(TimeAt(i * 100), i);
  EXPECT_EQ(more.size(), 11U);
  EXPECT_EQ(more.values().front().value, 10);
}

TEST(NumberSeries, StartsAgainWhenTheClockGoesBack) {
  NumberSeries series(std::chrono::seconds(100));
  series.Add(TimeAt(1000), 1);
  series.Add(TimeAt(2000), 2);
  series.Add(TimeAt(999), 3);
  ASSERT_EQ(series.size(), 1U);
  EXPECT_EQ(series.values().front().value, 3);
}

TEST(NumberSeries, OmitsSlightlyLateValues) {
  NumberSeries series(std::chrono::seconds(100));
  series.Add(TimeAt(1000), 1);
  series.Add(TimeAt(2000), 2);
  series.Add(TimeAt(1999), 3);
  series.Add(TimeAt(1000), 4);
  ASSERT_EQ(series.size(), 2U);
  EXPECT_EQ(series.values().back().value, 2);
}

TEST(NumberSeries, AcceptsExtremeTimesWithoutOverflow) {
  constexpr std::int64_t kEnd = std::numeric_limits<std::int64_t>::max();
  NumberSeries series(std::chrono::seconds(100));
  series.Add({0}, 1);
  series.Add({kEnd}, 2);
  series.Add({-kEnd - 1}, 3);
  series.Add({kEnd}, 4);
  ASSERT_EQ(series.size(), 1U);
  EXPECT_LT(series.values().back().at.nanoseconds, kEnd);
  const Time newest = series.values().back().at;
  EXPECT_EQ(series.Columns(newest - std::chrono::seconds(600), {newest.nanoseconds + 1}, 10).size(), 1U);
}

TEST(NumberSeries, ColumnsKeepEverySpike) {
  NumberSeries series(std::chrono::seconds(100));
  for (int i = 0; i < 10'000; ++i) series.Add(TimeAt(i), i == 4321 ? 1000 : std::sin(i));
  const auto columns = series.Columns(TimeAt(0), TimeAt(10'000), 100);
  ASSERT_EQ(columns.size(), 100U);
  EXPECT_EQ(columns[43].greatest, 1000);
  EXPECT_LT(columns[42].greatest, 2);
}

TEST(NumberSeries, ColumnsMatchANaiveModel) {
  std::mt19937 random(test::Seed());
  NumberSeries series(std::chrono::seconds(100));
  std::vector<NumberSeries::Value> all;
  std::int64_t now = 0;
  for (int i = 0; i < 3000; ++i) {
    now += static_cast<std::int64_t>(random() % 20);
    const double value = random() % 50 == 0 ? NAN : static_cast<double>(random() % 1000);
    series.Add(TimeAt(now), value);
    all.push_back({TimeAt(now), value});
  }
  const Time from = TimeAt(now / 3), to = TimeAt(now);
  const auto columns = series.Columns(from, to, 77);
  std::size_t values = 0;
  for (const auto& column : columns) {
    double least = INFINITY, greatest = -INFINITY;
    for (const auto& value : all) {
      const auto part = static_cast<double>((value.at - from).count()) / static_cast<double>((to - from).count());
      if (part < 0 || part >= 1 || !std::isfinite(value.value)) continue;
      if (static_cast<std::size_t>(part * 77) != column.column) continue;
      least = std::min(least, value.value);
      greatest = std::max(greatest, value.value);
      ++values;
    }
    ASSERT_EQ(column.least, least);
    ASSERT_EQ(column.greatest, greatest);
  }
  EXPECT_GT(values, 1000U);
}

TEST(NumberSeries, HasNoColumnsWithoutValuesOrRange) {
  NumberSeries series(std::chrono::seconds(1));
  EXPECT_TRUE(series.Columns(TimeAt(0), TimeAt(10), 10).empty());
  series.Add(TimeAt(5), 1);
  EXPECT_TRUE(series.Columns(TimeAt(0), TimeAt(10), 0).empty());
  EXPECT_TRUE(series.Columns(TimeAt(10), TimeAt(0), 10).empty());
  EXPECT_EQ(series.Columns(TimeAt(0), TimeAt(10), 10).size(), 1U);
}

}  // namespace
}  // namespace hgros::viewer
