#include "viewer/data/messages/plot_axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace hgros::viewer {
namespace {

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
