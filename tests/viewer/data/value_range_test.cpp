#include "viewer/data/value_range.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace hgros::viewer {
namespace {

TEST(ValueRange, StartsWithTheFirstValuesAndRarelyGrows) {
  ValueRange range;
  EXPECT_FALSE(range.known());
  EXPECT_TRUE(range.Cover(std::vector<float>{1, 2, 3}));
  EXPECT_EQ(range.lo(), 1);
  EXPECT_EQ(range.hi(), 3);
  EXPECT_FALSE(range.Cover(std::vector<float>{2}));
  int changes = 0;
  for (int i = 0; i < 1000; ++i) changes += range.Cover(std::vector<float>{static_cast<float>(i)}) ? 1 : 0;
  EXPECT_GE(range.hi(), 999);
  EXPECT_LT(changes, 40);
}

TEST(ValueRange, IgnoresOutliersAndValuesThatAreNotNumbers) {
  ValueRange range;
  std::vector<float> values(1000, 5);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += static_cast<float>(i) / 1000;
  values[3] = 1e9F;
  values[4] = std::numeric_limits<float>::quiet_NaN();
  range.Cover(values);
  EXPECT_LT(range.hi(), 10);
  EXPECT_FALSE(range.Cover(std::vector<float>{std::numeric_limits<float>::infinity()}));
  EXPECT_FALSE(range.Cover({}));
}

TEST(ValueRange, CountsOutliersIfAllOtherValuesAreEqual) {
  std::vector<float> values(1000, 5);
  values[3] = 9;
  ValueRange range;
  EXPECT_TRUE(range.Cover(values));
  EXPECT_EQ(range.lo(), 5);
  EXPECT_EQ(range.hi(), 9);
  values[3] = 1e9F;
  EXPECT_FALSE(range.Cover(values)) << "there is a range now";
  ValueRange one;
  one.Cover(std::vector<float>(1000, 5));
  EXPECT_LT(one.lo(), one.hi());
}

TEST(ValueRange, RecodedValuesStayTheSame) {
  ValueRange before;
  before.Cover(std::vector<float>{0, 10});
  ValueRange now = before;
  ASSERT_TRUE(now.Cover(std::vector<float>{40}));
  const std::vector<std::uint8_t> code = Recoding(before, now);
  for (const float value : {0.0F, 2.5F, 5.0F, 10.0F}) {
    const float again = now.lo() + static_cast<float>(code[EncodeIn(before, value)]) / 255 * (now.hi() - now.lo());
    EXPECT_NEAR(again, value, (now.hi() - now.lo()) / 255 + 10.0F / 255);
  }
}

}  // namespace
}  // namespace hgros::viewer
