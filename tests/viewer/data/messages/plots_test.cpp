#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "support/seed.hpp"
#include "viewer/data/messages/number_series.hpp"
#include "viewer/data/messages/plot_axis.hpp"

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

TEST(NumberSeries, TheLineBeginsAgainAfterSilenceOrAValueThatIsNotANumber) {
  NumberSeries series(std::chrono::seconds(100));
  for (int i = 0; i < 10; ++i) series.Add(TimeAt(100 * i + 50), i == 4 ? NAN : 1);
  for (int i = 50; i < 60; ++i) series.Add(TimeAt(100 * i + 50), 2);  // 4 s later
  std::vector<std::size_t> begin;
  for (const auto& column : series.Columns(TimeAt(0), TimeAt(6000), 60)) {
    if (column.begins) begin.push_back(column.column);
  }
  EXPECT_EQ(begin, (std::vector<std::size_t>{0, 5, 50}));
}

TEST(NumberSeries, SlowValuesAreNotSilence) {
  NumberSeries series(std::chrono::seconds(100));
  for (int i = 0; i < 5; ++i) series.Add(TimeAt(9000 * i), 1);
  const auto columns = series.Columns(TimeAt(0), TimeAt(45'000), 45);
  ASSERT_EQ(columns.size(), 5U);
  for (std::size_t i = 1; i < columns.size(); ++i) EXPECT_FALSE(columns[i].begins);
}

TEST(NumberSeries, ColumnsMatchANaiveModel) {
  std::mt19937 random(hgros::test::Seed());
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

TEST(PlotAxis, UsesRoundNumbers) {
  const AxisTicks ticks = TicksFor(-0.3, 1.1, 6);
  EXPECT_EQ(ticks.text, (std::vector<std::string>{"0.0", "0.5", "1.0"}));
  EXPECT_EQ(TicksFor(0, 100, 6).text, (std::vector<std::string>{"0", "20", "40", "60", "80", "100"}));
  EXPECT_EQ(TicksFor(-20, 0, 5).text, (std::vector<std::string>{"-20", "-15", "-10", "-5", "0"}));
}

TEST(PlotAxis, HasAtMostTheRequestedTicksAllInRange) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(-12, 12);
  std::uniform_real_distribution<double> middle(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const double span = std::pow(10, exponent(random));
    const double lo = middle(random) * span * 10;
    const std::size_t most = 2 + static_cast<std::size_t>(i) % 9;
    const AxisTicks ticks = TicksFor(lo, lo + span, most);
    ASSERT_LE(ticks.at.size(), most) << lo << " " << span;
    ASSERT_EQ(ticks.at.size(), ticks.text.size());
    ASSERT_GE(ticks.at.size(), most >= 4 ? 1U : 0U) << lo << " " << span;
    for (std::size_t t = 0; t < ticks.at.size(); ++t) {
      ASSERT_GE(ticks.at[t], lo - 1e-9 * span);
      ASSERT_LE(ticks.at[t], lo + span * (1 + 1e-9));
      ASSERT_TRUE(t == 0 || ticks.text[t] != ticks.text[t - 1]) << ticks.text[t];
    }
  }
}

TEST(PlotAxis, HasNoTicksForAnEmptyRange) {
  EXPECT_TRUE(TicksFor(1, 1, 5).at.empty());
  EXPECT_TRUE(TicksFor(2, 1, 5).at.empty());
  EXPECT_TRUE(TicksFor(0, std::numeric_limits<double>::infinity(), 5).at.empty());
  EXPECT_TRUE(TicksFor(std::nan(""), 1, 5).at.empty());
  EXPECT_TRUE(TicksFor(1e18, 1e18 + 128, 5).at.empty()) << "finer than the precision of the numbers";
}

TEST(PlotAxis, LeavesAMarginAroundEqualValues) {
  EXPECT_LT(RangeAround(5, 5).lo, 5);
  EXPECT_GT(RangeAround(5, 5).hi, 5);
  EXPECT_LT(RangeAround(0, 0).lo, 0);
  EXPECT_LT(RangeAround(-3, -3).lo, -3);
  EXPECT_EQ(RangeAround(1, 0).lo, 0) << "nothing to show";
}

TEST(PlotAxis, KnowsUnitsOfTheOpenSchemas) {
  EXPECT_EQ(UnitOfField("pose.position.x"), "m");
  EXPECT_EQ(UnitOfField("ranges[3]"), "m");
  EXPECT_EQ(UnitOfField("timestamp"), "s");
  EXPECT_EQ(UnitOfField("transforms[0].translation.z"), "m");
  EXPECT_EQ(UnitOfField("pose.orientation.x"), "");
  EXPECT_EQ(UnitOfField("x"), "");
}

}  // namespace
}  // namespace hgros::viewer
