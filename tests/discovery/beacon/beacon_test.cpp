#include "hgros/discovery/beacon.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <random>
#include <stop_token>
#include <thread>

#include "discovery/beacon/beacon_socket.hpp"
#include "discovery/beacon/datagram.hpp"
#include "discovery/listening.hpp"
#include "hgros/base/error.hpp"

namespace hgros::discovery::beacon_test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using test::Await;

struct LocalParticipant : Participant {
  explicit LocalParticipant(const BeaconOptions& options)
      : Participant([&](auto& listener, Log& kept) { return OpenBeacon(options, listener, kept); }) {
    own.endpoints = {"tcp://*:5555"};
  }
  /// The announcement that others get from its datagrams.
  [[nodiscard]] Announcement heard() const {
    return ParseDatagram(AsBytes(EncodeDatagram(own, "robot", false)), "robot", "127.0.0.1")->peer;
  }
};

/// Beacons on the loopback, at an address that no other test uses.
class Beacon : public testing::Test {
 protected:
  void SetUp() override {
    const LocalParticipant one(options);
    const LocalParticipant two(options);
    one.Announce();
    two.Announce();
    if (!one.log.text().empty()) GTEST_SKIP() << "no multicast on the loopback here: " << one.log.text();
  }

  BeaconOptions options{.domain = "robot",
                        .interfaces = {"lo"},
                        .port = static_cast<std::uint16_t>(10000 + getpid() % 20000),
                        .period = milliseconds(50),
                        .patience = hours(1)};
};

TEST_F(Beacon, LetsSessionsFindEachOtherAndSayGoodbye) {
  const LocalParticipant one(options);
  std::optional<LocalParticipant> two(options);
  one.Announce();
  two->Announce();
  const Announcement other = two->heard();
  EXPECT_EQ(other.endpoints, std::vector<std::string>{"tcp://127.0.0.1:5555"});
  EXPECT_TRUE(one.listening.AwaitPeer(other));
  EXPECT_TRUE(two->listening.AwaitPeer(one.heard()));
  EXPECT_EQ(one.discovery->List(), std::vector{other});
  two.reset();
  EXPECT_TRUE(one.listening.AwaitCount(0));
  EXPECT_EQ(one.listening.gone(other.session), "It said goodbye.");
  EXPECT_EQ(one.log.text(), "");
}

TEST_F(Beacon, SendsChangesAtOnceAndAnswersNewPeers) {
  options.period = hours(1);
  options.patience = hours(10);
  LocalParticipant early(options);
  early.Announce();
  const LocalParticipant late(options);
  late.Announce();
  EXPECT_TRUE(early.listening.AwaitPeer(late.heard()));
  EXPECT_TRUE(late.listening.AwaitPeer(early.heard())) << "long before the next period";
  early.own.endpoints = {"tcp://*:1", "tcp://*:2"};
  early.Announce();
  EXPECT_TRUE(late.listening.AwaitPeer(early.heard()));
  early.own.channels.clear();
  early.Announce();  // No change for others: datagrams contain no channels.
}

TEST_F(Beacon, ReportsSilentPeersAsGone) {
  options.patience = milliseconds(300);
  const LocalParticipant one(options);
  const BeaconSocket stranger({"lo"}, options.port);
  const Announcement brief = NewAnnouncement("brief");
  ASSERT_EQ(stranger.Send(EncodeDatagram(brief, "robot", false)), "");
  ASSERT_TRUE(Await([&] { return one.listening.came(brief.session) == 1; }));
  EXPECT_TRUE(one.listening.AwaitCount(0));
  EXPECT_EQ(one.listening.gone(brief.session), "It was not heard for 300 ms.");
}

TEST_F(Beacon, IgnoresOtherDomainsAndInvalidDatagrams) {
  const LocalParticipant one(options);
  const BeaconSocket stranger({"lo"}, options.port);
  std::mt19937 random(7);
  const std::string good = EncodeDatagram(NewAnnouncement(), "robot", false);
  (void)stranger.Send(EncodeDatagram(NewAnnouncement(), "other", false));
  for (int i = 0; i < 300; ++i) {
    std::string bad(random() % 3000, '\0');
    for (char& c : bad) c = static_cast<char>(random());
    (void)stranger.Send(bad);
    (void)stranger.Send(good.substr(0, random() % 8));
  }
  const LocalParticipant two(options);
  two.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(two.heard()));
  EXPECT_TRUE(one.listening.AwaitCount(1));
}

TEST_F(Beacon, SurvivesAFloodAndLogsIt) {
  const LocalParticipant one(options);
  const BeaconSocket stranger({"lo"}, options.port);
  const std::string stranger_datagram = EncodeDatagram(NewAnnouncement(), "robot", false);
  // Repeat until it is logged: the kernel drops some of the datagrams.
  ASSERT_TRUE(Await([&] {
    for (int i = 0; i < 1000; ++i) (void)stranger.Send(stranger_datagram);
    return one.log.Count({"datagrams a second"}) == 1;
  }));
  const LocalParticipant two(options);
  two.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(two.heard()));
}

TEST_F(Beacon, HearsSessionsInAFloodOfGarbage) {
  const LocalParticipant one(options);
  const BeaconSocket stranger({"lo"}, options.port);
  const std::string garbage(100, 'x');
  const std::jthread flood([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      for (int i = 0; i < 20; ++i) (void)stranger.Send(garbage);  // 10,000 in a second.
      test::Linger(milliseconds(2));
    }
  });
  test::Linger(milliseconds(1500));
  EXPECT_EQ(one.log.text(), "") << "a few thousand datagrams of others are no reason to be deaf";
  const LocalParticipant two(options);
  two.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(two.heard()));
}

TEST_F(Beacon, RefusesInvalidOptions) {
  LocalParticipant one(options);
  const Announcement good = one.own;
  one.own.session = {};
  EXPECT_THROW(one.Announce(), Error);
  one.own = good;
  one.own.endpoints.assign(17, "tcp://192.0.2.9:1");
  EXPECT_THROW(one.Announce(), Error);
  one.own = good;
  EXPECT_NO_THROW(one.Announce());
  one.own.session = SessionId::Random();
  EXPECT_THROW(one.Announce(), Error) << "one beacon, one session";

  Listening listening;
  KeptLog log;
  const auto refused = [&](const BeaconOptions& wrong) {
    EXPECT_THROW((void)OpenBeacon(wrong, listening, log.log), Error);
  };
  BeaconOptions wrong = options;
  wrong.domain = "no domain";
  refused(wrong);
  wrong = options;
  wrong.patience = wrong.period;
  refused(wrong);
}

TEST_F(Beacon, ForkedChildDoesNotDisturbIt) {
  const LocalParticipant one(options);
  LocalParticipant two(options);
  one.Announce();
  two.Announce();
  ASSERT_TRUE(one.listening.AwaitPeer(two.heard()));
  EXPECT_EQ(UseInForkedChild(two.discovery, two.own), 0);
  two.own.endpoints = {"tcp://*:7"};
  two.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(two.heard()));
  EXPECT_EQ(one.listening.came(two.own.session), 1) << "the child has sent no goodbye";
}

}  // namespace
}  // namespace hgros::discovery::beacon_test
