#include "discovery/beacon/beacon_peers.hpp"

#include <gtest/gtest.h>

#include <string>

#include "discovery/listening.hpp"

namespace hgros::discovery {
namespace {

using std::chrono::milliseconds;
using Verdict = BeaconPeers::Verdict;

class BeaconPeersTest : public testing::Test {
 protected:
  static Heard From(const Announcement& peer, bool ends = false) { return {peer, ends}; }
  ~BeaconPeersTest() override {
    book.Tell(listening);
    EXPECT_EQ(listening.broken(), "");
  }
  [[nodiscard]] std::size_t count() {
    book.Tell(listening);
    EXPECT_EQ(book.List(), listening.here());
    return book.List().size();
  }

  PeerBook book;
  Listening listening;
  BeaconPeers peers{book, milliseconds(100)};
  const BeaconPeers::Clock::time_point start = BeaconPeers::Clock::now();
  const Announcement one = NewAnnouncement("one");
};

TEST_F(BeaconPeersTest, ExpireAfterTheirPatience) {
  EXPECT_FALSE(peers.next_expiry());
  EXPECT_EQ(peers.Hear(From(one), "a", start), Verdict::kNew);
  EXPECT_EQ(peers.Hear(From(one), "a", start + milliseconds(60)), Verdict::kKnown);
  peers.Expire(start + milliseconds(159));
  EXPECT_EQ(count(), 1U);
  EXPECT_EQ(peers.next_expiry(), start + milliseconds(160));
  peers.Expire(start + milliseconds(160));
  EXPECT_EQ(count(), 0U);
  EXPECT_EQ(listening.gone(one.session), "It was not heard for 100 ms.");
}

TEST_F(BeaconPeersTest, LeaveWhenTheySayGoodbye) {
  EXPECT_EQ(peers.Hear(From(one, true), "a", start), Verdict::kIgnored);
  (void)peers.Hear(From(one), "a", start);
  (void)peers.Hear(From(one, true), "a", start);
  EXPECT_EQ(count(), 0U);
  EXPECT_EQ(listening.gone(one.session), "It said goodbye.");
}

TEST_F(BeaconPeersTest, KeepTheirFirstAddressUntilTheyExpire) {
  Announcement elsewhere = one;
  elsewhere.endpoints = {"tcp://elsewhere:1"};
  (void)peers.Hear(From(one), "a", start);
  EXPECT_EQ(peers.Hear(From(elsewhere), "b", start), Verdict::kIgnored);
  EXPECT_EQ(peers.Hear(From(elsewhere, true), "b", start), Verdict::kIgnored);
  EXPECT_EQ(count(), 1U);
  EXPECT_TRUE(listening.Sees(one));
  EXPECT_EQ(peers.Hear(From(elsewhere), "b", start + milliseconds(100)), Verdict::kNew);
  EXPECT_EQ(count(), 1U);
  EXPECT_TRUE(listening.Sees(elsewhere));
}

TEST_F(BeaconPeersTest, RestartedPeersReplaceTheirEarlierIncarnations) {
  Announcement reborn = one;
  reborn.incarnation = 2;
  (void)peers.Hear(From(one), "a", start);
  EXPECT_EQ(peers.Hear(From(reborn), "a", start), Verdict::kNew);
  EXPECT_EQ(peers.Hear(From(one), "a", start), Verdict::kIgnored);
  EXPECT_EQ(count(), 1U);
  EXPECT_EQ(listening.came(one.session), 2);
  EXPECT_TRUE(listening.Sees(reborn));
}

TEST_F(BeaconPeersTest, AreLimitedInNumber) {
  for (std::size_t i = 1; i <= BeaconPeers::kMaxPeers; ++i) {
    Announcement peer;
    peer.session = {i};
    EXPECT_EQ(peers.Hear(From(peer), "a", start), Verdict::kNew);
  }
  EXPECT_EQ(peers.Hear(From(one), "a", start), Verdict::kTooMany);
  EXPECT_EQ(peers.Hear(From(one), "a", start + milliseconds(100)), Verdict::kNew) << "the other peers have expired";
  EXPECT_EQ(count(), 1U);
}

TEST_F(BeaconPeersTest, OfTheAddressWithTheMostMakeRoomForThoseOfOthers) {
  for (std::size_t i = 1; i <= 2 * BeaconPeers::kMaxPeers; ++i) {
    Announcement peer;
    peer.session = {i};
    (void)peers.Hear(From(peer), "flood", start);
  }
  EXPECT_EQ(peers.Hear(From(one), "a", start), Verdict::kNew);
  EXPECT_EQ(peers.Hear(From(NewAnnouncement("two")), "a", start), Verdict::kNew);
  EXPECT_EQ(peers.Hear(From(NewAnnouncement("three")), "flood", start), Verdict::kTooMany);
  EXPECT_EQ(count(), BeaconPeers::kMaxPeers);
  EXPECT_TRUE(listening.Sees(one));
  EXPECT_EQ(peers.Hear(From(one), "a", start + milliseconds(50)), Verdict::kKnown);
  peers.Expire(start + milliseconds(100));
  EXPECT_EQ(count(), 1U);
}

}  // namespace
}  // namespace hgros::discovery
