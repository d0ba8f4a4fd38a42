#include "viewer/data/value_range.hpp"

#include <gtest/gtest.h>

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
  for (int i = 0; i < 1000; ++i) {
    changes += range.Cover(std::vector<float>{static_cast<float>(i)}, ValueRange::kAllMessages) ? 1 : 0;
  }
  EXPECT_LE(range.lo(), 7);
  EXPECT_GE(range.hi(), 992) << "without the outer 1 % of the messages";
  EXPECT_LT(changes, 40);
}

TEST(ValueRange, KeepsItsLimitsIfMessagesVaryALittle) {
  ValueRange range;
  for (int i = 0; i < 40; ++i) {
    const float limit = 50 + 0.05F * static_cast<float>(i % 30);
    EXPECT_EQ(range.Cover(std::vector<float>{-limit, 0, limit}), i == 0) << i;
  }
  EXPECT_EQ(range.lo(), -50);
  EXPECT_EQ(range.hi(), 50);
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

/// Covers a message of 0, 1, ... 100, times `scale`.
bool CoverHundred(ValueRange& range, float scale) {
  std::vector<float> values(101);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = scale * static_cast<float>(i);
  return range.Cover(values);
}

TEST(ValueRange, ShrinksAgainAfterAMessageWithAbsurdValues) {
  ValueRange range;
  for (int i = 0; i < 5; ++i) CoverHundred(range, 1);
  CoverHundred(range, 100);
  EXPECT_GT(range.hi(), 9000) << "it may be the new usual";
  for (int i = 0; i < 16; ++i) CoverHundred(range, 1);
  EXPECT_LT(range.hi(), 150);
  EXPECT_FALSE(CoverHundred(range, 100)) << "one among many does not count";
  EXPECT_TRUE(CoverHundred(range, 100)) << "two do";
}

TEST(ValueRange, AMessageThatStandsForSeveralCountsAsThese) {
  for (const std::size_t weight : {1U, 3U}) {
    ValueRange range;
    range.Cover(std::vector<float>{900, 1000}, ValueRange::kAllMessages, weight);
    for (int i = 0; i < 50; ++i) range.Cover(std::vector<float>{0, 10}, ValueRange::kAllMessages);
    EXPECT_EQ(range.hi() > 900, weight > 1);
  }
}

TEST(ValueRange, FollowsSmallerValues) {
  ValueRange range;
  for (int i = 0; i < 20; ++i) CoverHundred(range, 1);
  int changes = 0;
  for (int i = 0; i < 40; ++i) changes += CoverHundred(range, 0.1F) ? 1 : 0;
  EXPECT_EQ(changes, 1);
  EXPECT_LT(range.hi(), 20);
}

}  // namespace
}  // namespace hgros::viewer
