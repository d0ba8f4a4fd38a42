#include "viewer/scene/displays/settling.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

TEST(Settling, SettlesAtOnceAndDrawsTheFirstMessageOnce) {
  Settling settling;
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_TRUE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_TRUE(settling.TakeSettled());
  EXPECT_FALSE(settling.moves());
}

TEST(Settling, MovesUntilItHasNotBeenReplacedForAWhile) {
  Settling settling;
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_EQ(settling.Replaced(1), Change::kRedraw);
  EXPECT_TRUE(settling.moves());
  EXPECT_EQ(settling.next_change_s(), 3);
  EXPECT_EQ(settling.Replaced(2), Change::kMoving);
  EXPECT_FALSE(settling.TakeNew());
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Rest(3.9), Change::kNothing);
  EXPECT_EQ(settling.Rest(4), Change::kAppended);
  EXPECT_TRUE(settling.settled());
  EXPECT_TRUE(settling.TakeNew());
}

TEST(Settling, StartsAgainAfterItWasRemoved) {
  Settling settling;
  EXPECT_EQ(settling.Gone(), Change::kMoving);
  EXPECT_EQ(settling.Replaced(0), Change::kAppended);
  EXPECT_EQ(settling.Gone(), Change::kRedraw);
  EXPECT_FALSE(settling.TakeSettled());
  EXPECT_EQ(settling.Replaced(1), Change::kAppended);
}

}  // namespace
}  // namespace hgros::viewer
