#include "hgros/base/ids.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <unordered_set>

#include "hgros/base/session_name.hpp"

namespace hgros {
namespace {

TEST(SessionId, IsWrittenAsSixteenLowerCaseDigits) {
  EXPECT_EQ(SessionId{0x1}.ToString(), "0000000000000001");
  EXPECT_EQ(SessionId{0xfedcba9876543210}.ToString(), "fedcba9876543210");
}

TEST(SessionId, ReadsBackWhatItWrites) {
  for (int i = 0; i < 1000; ++i) {
    const SessionId id = SessionId::Random();
    ASSERT_EQ(SessionId::FromString(id.ToString()), id) << id.ToString();
  }
}

TEST(SessionId, RefusesOtherTexts) {
  for (const char* text : {"", "1", "fedcba987654321", "fedcba98765432100", "FEDCBA9876543210", "0xdcba9876543210",
                           "fedcba987654321g", " edcba9876543210", "-edcba9876543210"}) {
    EXPECT_EQ(SessionId::FromString(text), SessionId{}) << text;
  }
}

TEST(SessionId, IsAKeyOfOrderedAndHashedContainers) {
  const std::set<SessionId> ordered = {{3}, {1}, {2}, {1}};
  EXPECT_EQ(ordered.begin()->value, 1U);
  const std::unordered_set<SessionId> hashed(ordered.begin(), ordered.end());
  EXPECT_EQ(hashed.size(), 3U);
}

TEST(SessionName, NamesProcessAndAnotherHost) {
  std::array<char, 256> here{};
  ASSERT_EQ(gethostname(here.data(), here.size() - 1), 0);
  EXPECT_EQ(SessionName("talker", 42), "talker:42");
  EXPECT_EQ(SessionName("talker", 42, here.data()), "talker:42");
  EXPECT_EQ(SessionName("talker", 42, "not " + std::string(here.data())), "talker:42@not " + std::string(here.data()));
}

TEST(MessageId, IsOrderedByPublisherThenIncarnationThenSequence) {
  EXPECT_LT((MessageId{1, 9, 9}), (MessageId{2, 0, 0}));
  EXPECT_LT((MessageId{1, 1, 9}), (MessageId{1, 2, 0}));
  EXPECT_LT((MessageId{1, 1, 1}), (MessageId{1, 1, 2}));
  EXPECT_EQ((MessageId{1, 1, 1}), (MessageId{1, 1, 1}));
}

TEST(RandomId, IsNeverZeroAndNeverTheSameFromAnyThread) {
  constexpr std::size_t kEach = 2000;
  for (const std::size_t thread_count : {1U, 2U, 4U}) {
    std::mutex mutex;
    std::set<std::uint64_t> seen;
    {
      std::vector<std::jthread> threads;
      for (std::size_t t = 0; t < thread_count; ++t) {
        threads.emplace_back([&] {
          for (std::size_t i = 0; i < kEach; ++i) {
            const std::uint64_t id = RandomId();
            const std::scoped_lock lock(mutex);
            seen.insert(id);
          }
        });
      }
    }
    EXPECT_EQ(seen.size(), thread_count * kEach);
    EXPECT_FALSE(seen.contains(0));
  }
}

}  // namespace
}  // namespace hgros
