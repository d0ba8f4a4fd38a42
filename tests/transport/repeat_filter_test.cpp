#include "transport/repeat_filter.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace hgros {
namespace {

TEST(RepeatFilter, PassesMessagesWithoutAnId) {
  RepeatFilter filter;
  EXPECT_TRUE(filter.Pass(SessionId{}, {}));
  EXPECT_TRUE(filter.Pass(SessionId{}, {}));
}

TEST(RepeatFilter, NewIncarnationStartsAgainAndTheOldOneIsRefused) {
  RepeatFilter filter;
  EXPECT_TRUE(filter.Pass(SessionId{}, {7, 1, 5}));
  EXPECT_TRUE(filter.Pass(SessionId{}, {7, 2, 5}));
  EXPECT_FALSE(filter.Pass(SessionId{}, {7, 1, 6}));
  EXPECT_FALSE(filter.Pass(SessionId{}, {7, 2, 5}));
}

TEST(RepeatFilter, SenderCannotTurnMessagesOfOthersIntoRepeats) {
  RepeatFilter filter;
  EXPECT_TRUE(filter.Pass(SessionId{9}, {7, ~std::uint64_t{0}, 1}));
  EXPECT_TRUE(filter.Pass(SessionId{7}, {7, 1, 1}));
  EXPECT_TRUE(filter.Pass(SessionId{}, {7, 1, 1}));
  EXPECT_FALSE(filter.Pass(SessionId{7}, {7, 1, 1}));
}

TEST(RepeatFilter, BehavesLikeASetWithinItsWindow) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    RepeatFilter filter;
    std::set<std::uint64_t> seen;
    std::uint64_t highest = 0;
    for (int step = 0; step < 2000; ++step) {
      const std::uint64_t jump = random() % 50 == 0 ? random() % 1000 : random() % 4;
      std::uint64_t sequence = highest + jump;
      if (const std::uint64_t back = random() % 300; random() % 2 == 0 && back < sequence) sequence -= back;
      if (sequence == 0) continue;
      const bool old = sequence <= highest && highest - sequence >= RepeatFilter::kWindow;
      ASSERT_EQ(filter.Pass(SessionId{}, {1, 1, sequence}), !old && !seen.contains(sequence))
          << "sequence " << sequence;
      seen.insert(sequence);
      highest = std::max(highest, sequence);
    }
  }
}

}  // namespace
}  // namespace hgros
