#include "component/number_gaps.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace hgros::test {
namespace {

using testing::ElementsAre;

std::vector<std::uint64_t> Missing(std::uint64_t last, const NumberGaps& gaps) {
  std::vector<std::uint64_t> found;
  for (std::uint64_t number = 0; number <= last; ++number) {
    if (gaps.Has(number)) found.push_back(number);
  }
  return found;
}

TEST(NumberGaps, KnowWhatIsMissing) {
  NumberGaps gaps;
  gaps.Note(0, 5);  // What came before the first is not known.
  EXPECT_TRUE(gaps.empty());
  gaps.Note(5, 6);
  EXPECT_TRUE(gaps.empty());
  gaps.Note(6, 10);
  EXPECT_THAT(Missing(20, gaps), ElementsAre(7, 8, 9));
  gaps.Note(10, 8);
  EXPECT_THAT(Missing(20, gaps), ElementsAre(7, 9));
  gaps.Note(10, 10);
  gaps.Note(10, 3);
  gaps.Note(10, 7);
  EXPECT_THAT(Missing(20, gaps), ElementsAre(9));
  gaps.Note(10, 9);
  EXPECT_TRUE(gaps.empty());
  gaps.Note(10, 12);
  gaps.Clear();
  EXPECT_TRUE(gaps.empty());
}

TEST(NumberGaps, ForgetTheOldestFirst) {
  NumberGaps gaps;
  std::uint64_t last = 1;
  for (int i = 0; i < 1000; ++i) {
    gaps.Note(last, last + 2);
    last += 2;
  }
  const std::vector<std::uint64_t> known = Missing(last, gaps);
  ASSERT_EQ(known.size(), 64U);
  EXPECT_EQ(known.back(), last - 1);
  EXPECT_EQ(known.front(), last - 127);
}

TEST(NumberGaps, AreThoseOfASet) {
  const auto seed = static_cast<std::uint32_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE("--gtest_shuffle --gtest_random_seed=" + std::to_string(seed));
  std::mt19937 random(seed);
  for (int round = 0; round < 200; ++round) {
    NumberGaps gaps;
    std::set<std::uint64_t> missing;
    std::uint64_t last = 1;
    for (int i = 0; i < 60; ++i) {
      const std::uint64_t number = random() % 2 == 0 ? last + 1 + random() % 4 : 1 + random() % last;
      gaps.Note(last, number);
      for (std::uint64_t between = last + 1; between < number; ++between) missing.insert(between);
      missing.erase(number);
      last = std::max(last, number);
      ASSERT_EQ(Missing(last + 1, gaps), std::vector<std::uint64_t>(missing.begin(), missing.end()));
    }
  }
}

}  // namespace
}  // namespace hgros::test
