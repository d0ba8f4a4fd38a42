#include "robot/measurements.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

TEST(Measurements, HaveMeanExtremesAndQuantiles) {
  Measurements all;
  EXPECT_EQ(all.Mean(), 0);
  EXPECT_EQ(all.Quantile(0.5), 0);
  for (const double value : {3.0, 1.0, 2.0, 10.0}) all.Add(value);
  EXPECT_EQ(all.count(), 4U);
  EXPECT_EQ(all.min(), 1);
  EXPECT_EQ(all.max(), 10);
  EXPECT_EQ(all.Mean(), 4);
  EXPECT_EQ(all.Quantile(0), 1);
  EXPECT_EQ(all.Quantile(0.5), 3);
  EXPECT_EQ(all.Quantile(1), 10);
}

TEST(Measurements, HaveBarsOfRoundWidthThatCountEachValueOnce) {
  Measurements all;
  for (int i = 0; i < 1000; ++i) all.Add(100 + i % 10);
  all.Add(-50);
  all.Add(5000);
  const std::vector<Bar> bars = all.Bars(5);
  ASSERT_EQ(bars.size(), 5U);
  EXPECT_EQ(bars[0].from, -50);
  EXPECT_EQ(bars[0].to, 102);
  EXPECT_EQ(bars[0].count, 201U);
  EXPECT_EQ(bars[1].from, 102);
  EXPECT_EQ(bars[1].to, 104);
  EXPECT_EQ(bars[1].count, 200U);
  EXPECT_EQ(bars[4].to, 5000);
  EXPECT_EQ(bars[4].count, 201U);
}

TEST(Measurements, HaveOneBarForEqualValuesAndFewForOneThatDiffers) {
  Measurements all;
  EXPECT_TRUE(all.Bars(5).empty());
  for (int i = 0; i < 1000; ++i) all.Add(7);
  ASSERT_EQ(all.Bars(5).size(), 1U);
  EXPECT_EQ(all.Bars(5)[0].count, 1000U);
  all.Add(107);
  const std::vector<Bar> bars = all.Bars(5);
  EXPECT_EQ(bars.front().count, 1000U);
  EXPECT_EQ(bars.back().count, 1U);
}

TEST(Measurements, DescribeOnlyTheLastTenThousandInBars) {
  Measurements all;
  for (int i = 0; i < 10'000; ++i) all.Add(1);
  for (int i = 0; i < 10'000; ++i) all.Add(2);
  ASSERT_EQ(all.Bars(5).size(), 1U);
  EXPECT_EQ(all.Bars(5)[0].from, 2);
  EXPECT_EQ(all.count(), 20'000U);
  EXPECT_EQ(all.min(), 1);
}

}  // namespace
}  // namespace hgros::cli
