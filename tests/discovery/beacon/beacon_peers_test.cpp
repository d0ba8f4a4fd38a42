#include "discovery/beacon/beacon_peers.hpp"

#include <gtest/gtest.h>

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

// A stranger may repeat the datagrams of a session from its own address, with its own endpoint.
TEST_F(BeaconPeersTest, AreAtAllAddressesFromWhichTheyAreHeard) {
  Announcement here = one;
  here.endpoints = {"tcp://here:1", "tcp://both:1"};
  Announcement elsewhere = one;
  elsewhere.process = "another";
  elsewhere.endpoints = {"tcp://elsewhere:1", "tcp://both:1"};
  (void)peers.Hear(From(here), "a", start);
  EXPECT_EQ(peers.Hear(From(elsewhere, true), "b", start), Verdict::kIgnored);
  EXPECT_EQ(peers.Hear(From(elsewhere), "b", start + milliseconds(50)), Verdict::kNew);
  Announcement both = here;
  both.endpoints = {"tcp://here:1", "tcp://both:1", "tcp://elsewhere:1"};
  both.senders = {"a", "a", "b"};
  EXPECT_EQ(count(), 1U);
  EXPECT_TRUE(listening.Sees(both));
  EXPECT_EQ(peers.next_expiry(), start + milliseconds(100));
  peers.Expire(start + milliseconds(100));
  EXPECT_TRUE(listening.Sees(both)) << "not told yet";
  EXPECT_EQ(count(), 1U);
  EXPECT_TRUE(listening.Sees(elsewhere));
  EXPECT_EQ(peers.Hear(From(here), "a", start + milliseconds(100)), Verdict::kNew);
  EXPECT_EQ(peers.Hear(From(elsewhere, true), "b", start + milliseconds(100)), Verdict::kKnown);
  EXPECT_EQ(count(), 1U);
  EXPECT_TRUE(listening.Sees(here));
}

TEST_F(BeaconPeersTest, HaveTheirTurnIfManyAddressesClaimThem) {
  const auto from = [&](int i) {
    Announcement peer = one;
    peer.endpoints = {"tcp://host" + std::to_string(i) + ":1"};
    return From(peer);
  };
  constexpr int kMany = 3 * BeaconPeers::kMaxPlaces;
  for (int i = 0; i < kMany; ++i) {
    const bool fits = i < static_cast<int>(BeaconPeers::kMaxPlaces);
    EXPECT_EQ(peers.Hear(from(i), std::to_string(i), start), fits ? Verdict::kNew : Verdict::kKnown) << i;
  }
  EXPECT_EQ(count(), 1U);
  constexpr int kFirst = kMany - BeaconPeers::kMaxPlaces;
  Announcement last = from(kFirst).peer;
  last.endpoints.clear();
  for (int i = kFirst; i < kMany; ++i) {
    last.endpoints.push_back(from(i).peer.endpoints.front());
    last.senders.push_back(std::to_string(i));
  }
  EXPECT_TRUE(listening.Sees(last));
  peers.Expire(start + milliseconds(100));
  EXPECT_EQ(count(), 0U);
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
