#include "session/clock_follower.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace hgros {
namespace {

class ClockFollowerTest : public testing::Test {
 protected:
  // The message of a paused clock.
  void Say(std::uint64_t session, std::int64_t shown, bool ended = false) {
    SimulatedTime time;
    time.set_time_ns(shown);
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
  ClockFollower follower{clock, std::make_shared<Log>([](LogLevel, std::string_view) {})};
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

}  // namespace
}  // namespace hgros
