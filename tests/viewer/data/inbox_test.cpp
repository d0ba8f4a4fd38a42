#include "viewer/data/inbox.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace hgros::viewer {
namespace {

TEST(Inbox, KeepsTheNewestAndCountsWhatItDrops) {
  Inbox<int> inbox(3);
  for (int i = 0; i < 5; ++i) inbox.Put(std::make_shared<const int>(i));
  const auto taken = inbox.TakeAll();
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_EQ(*taken.front(), 2);
  EXPECT_EQ(*taken.back(), 4);
  EXPECT_EQ(inbox.received(), 5U);
  EXPECT_EQ(inbox.dropped(), 2U);
}

TEST(Inbox, KeepsBelowItsLimitOfBytes) {
  constexpr std::size_t kMost = Inbox<int>::kMostBytes;
  Inbox<int> inbox(1024);
  for (int i = 0; i < 8; ++i) inbox.Put(std::make_shared<const int>(i), kMost / 4);
  EXPECT_EQ(inbox.dropped(), 4U);
  inbox.Put(std::make_shared<const int>(8), kMost / 2);
  EXPECT_EQ(inbox.dropped(), 6U);
  EXPECT_EQ(inbox.TakeAll().size(), 3U);
  inbox.Put(std::make_shared<const int>(9), kMost);
  EXPECT_EQ(inbox.dropped(), 6U) << "taken messages no longer count";
  inbox.Put(std::make_shared<const int>(10), 10 * kMost);
  const auto taken = inbox.TakeAll();
  ASSERT_EQ(taken.size(), 1U) << "the newest message stays at any size";
  EXPECT_EQ(*taken.front(), 10);
  EXPECT_EQ(inbox.dropped(), 7U);
}

TEST(Inbox, ReturnsTheNewestIfOnlySomeAreWanted) {
  Inbox<int> inbox(5);
  for (int i = 0; i < 4; ++i) inbox.Put(std::make_shared<const int>(i));
  const auto taken = inbox.TakeAll(1);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(*taken.front(), 3);
  EXPECT_EQ(inbox.dropped(), 3U);
  EXPECT_TRUE(inbox.TakeAll().empty());
}

TEST(Inbox, AsksForAWakeUpOnlyForTheFirstMessage) {
  Inbox<int> inbox(3);
  EXPECT_TRUE(inbox.Put(std::make_shared<const int>(0)));
  EXPECT_FALSE(inbox.Put(std::make_shared<const int>(1)));
  (void)inbox.TakeAll();
  EXPECT_TRUE(inbox.Put(std::make_shared<const int>(2)));
}

}  // namespace
}  // namespace hgros::viewer
