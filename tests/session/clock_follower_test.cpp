#include "session/clock_follower.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>

namespace hgros::test {
namespace {

class ClockFollowerTest : public testing::Test {
 protected:
  // The message of a paused clock.
  void Say(std::uint64_t session, std::int64_t shown, bool ended = false, std::int64_t jumped = 0) {
    SimulatedTime time;
    time.set_time_ns(shown);
    time.set_jumped_ns(jumped);
    time.set_rate(1);
    time.set_paused(true);
    time.set_clock_id(session);
    time.set_ended(ended);
    MessageInfo info;
    info.id.publisher = session;
    follower.OnTime(time, info);
  }
  void Tell(PeerEvent::Kind kind, std::uint64_t session) {
    PeerEvent event;
    event.kind = kind;
    event.peer.id = SessionId{session};
    follower.OnPeer(event);
  }

  const std::shared_ptr<FollowingClock> clock = std::make_shared<FollowingClock>();
  std::string said;
  ClockFollower follower{clock, std::make_shared<Log>([this](LogLevel, std::string_view text) { said += text; })};
};

TEST_F(ClockFollowerTest, LatestMessageOfAReturningSessionCountsOnceItsReturnIsReported) {
  Say(7, 10);
  EXPECT_EQ(clock->Now(), Time{10});
  Tell(PeerEvent::Kind::kGone, 7);
  Say(7, 20);
  Say(7, 30);
  EXPECT_EQ(clock->Now(), Time{10}) << "the messages may be late ones";
  Tell(PeerEvent::Kind::kCame, 7);
  EXPECT_EQ(clock->Now(), Time{30});
  Say(7, 40);
  EXPECT_EQ(clock->Now(), Time{40});
}

TEST_F(ClockFollowerTest, IgnoresMessagesOfASessionThatIsGoneAgain) {
  Say(7, 10);
  Tell(PeerEvent::Kind::kGone, 7);
  Say(7, 20);
  Tell(PeerEvent::Kind::kGone, 7);
  Tell(PeerEvent::Kind::kCame, 7);
  EXPECT_EQ(clock->Now(), Time{10});
  Say(8, 50);
  EXPECT_EQ(clock->Now(), Time{50}) << "no other clock is followed";
}

TEST_F(ClockFollowerTest, SessionThatReturnsWhileAnotherIsFollowedBecomesTheRival) {
  Say(7, 10);
  Tell(PeerEvent::Kind::kGone, 7);
  Say(8, 50);
  Say(7, 20);
  Tell(PeerEvent::Kind::kCame, 7);
  EXPECT_EQ(clock->Now(), Time{50});
  Say(8, 60, true);
  EXPECT_EQ(clock->Now(), Time{20});
}

TEST_F(ClockFollowerTest, AClockThatGoesBackWithoutAJumpIsTakenAsOneThatJumps) {
  Say(7, 9'000'000'000);
  Say(7, 5'000'000'000, false, -4'000'000'000);
  EXPECT_EQ(clock->Now(), Time{5'000'000'000});
  EXPECT_EQ(said, "");
  Say(7, 2'500'000'000, false, -4'000'000'000);
  EXPECT_EQ(clock->Now(), Time{2'500'000'000});
  EXPECT_EQ(clock->Read().elapsed(), Time{0}) << "no time has passed";
  EXPECT_NE(said.find("went back by 2.500000 s without saying that it jumped"), std::string::npos) << said;
}

}  // namespace
}  // namespace hgros::test
