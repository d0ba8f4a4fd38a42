#include "bridge/stranger_channels.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace hgros {
namespace {

using Uses = std::vector<std::pair<std::string, StrangerChannels::Use>>;

Uses Channels(SessionId session, std::size_t first, std::size_t count) {
  Uses uses;
  for (std::size_t i = first; i < first + count; ++i) {
    uses.emplace_back("channel" + std::to_string(i), StrangerChannels::Use{session, true, false, {}});
  }
  return uses;
}

TEST(StrangerChannels, FindTheSessionsOfOneChannelAmongManyWithoutTheOthers) {
  StrangerChannels strangers;
  for (std::uint64_t i = 1; i <= 4; ++i) strangers.Remember(SessionId{i}, Channels(SessionId{i}, 0, 12'000));
  strangers.Remember(SessionId{9}, Channels(SessionId{9}, 12'000, 1));
  EXPECT_EQ(strangers.UsesOf("channel7").size(), 4U);
  EXPECT_TRUE(strangers.UsesOf("another").empty());
  const auto last = strangers.UsesOf("channel12000");
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(last[0].session, SessionId{9});
}

TEST(StrangerChannels, ForgetWhatASessionNoLongerAnnounces) {
  StrangerChannels strangers;
  strangers.Remember(SessionId{1}, Channels(SessionId{1}, 0, 3));
  strangers.Remember(SessionId{2}, Channels(SessionId{2}, 0, 3));
  strangers.Remember(SessionId{1}, Channels(SessionId{1}, 2, 2));
  EXPECT_EQ(strangers.UsesOf("channel0").size(), 1U);
  EXPECT_EQ(strangers.UsesOf("channel2").size(), 2U);
  EXPECT_EQ(strangers.UsesOf("channel3").size(), 1U);
  strangers.Forget(SessionId{2});
  EXPECT_TRUE(strangers.UsesOf("channel0").empty());
  Uses twice = Channels(SessionId{3}, 5, 1);
  twice.push_back(twice.front());
  strangers.Remember(SessionId{3}, std::move(twice));
  strangers.Forget(SessionId{3});
  EXPECT_TRUE(strangers.UsesOf("channel5").empty());
}

}  // namespace
}  // namespace hgros
