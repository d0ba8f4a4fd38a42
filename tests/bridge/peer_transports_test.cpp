#include "bridge/peer_transports.hpp"

#include <gtest/gtest.h>

#include "conformance/transport_conformance.hpp"
#include "hgros/base/error.hpp"

namespace hgros::peer_transports_test {
namespace {

constexpr TransportIndex kShm = 0;
constexpr TransportIndex kZmq = 1;
const TransportSet kOnlyShm{kShm};
const TransportSet kOnlyZmq{kZmq};

TransportEntry Entry(const std::string& key, const std::string& name, int cost,
                     TransportReach reach = TransportReach::kNetwork) {
  return {key, name, cost, reach, {}, true};
}

TEST(ListOfTransports, HasTheCheapestFirst) {
  const TransportList list({Entry("far", "the far", 3), Entry("near", "the near", 1, TransportReach::kHost),
                            Entry("between", "the between", 2)});
  EXPECT_EQ(list.Find("near"), 0U);
  EXPECT_EQ(list.Find("between"), 1U);
  EXPECT_EQ(list.Find("far"), 2U);
  EXPECT_EQ(list.Find("elsewhere"), std::nullopt);
  EXPECT_EQ(list.on_host(), TransportSet{0});
  EXPECT_EQ(list.NamesOf({0, 2}), "the near and the far");
}

TEST(ListOfTransports, TurnsKeysIntoSets) {
  const TransportList list({Entry("a", "the a", 1), Entry("b", "the b", 2)});
  EXPECT_EQ(list.SetOf(std::nullopt), list.all());
  EXPECT_EQ(list.SetOf(std::vector<std::string>{"b", "unknown"}), TransportSet{1});
  EXPECT_TRUE(list.SetOf(std::vector<std::string>{"unknown"}).empty());
}

TEST(ListOfTransports, RefusesTwoWithOneKey) {
  EXPECT_THROW(TransportList({Entry("a", "the a", 1), Entry("a", "the a", 2)}), Error);
}

TEST(SetOfTransports, ReturnsItsCheapest) {
  const TransportSet set{1, 4};
  EXPECT_EQ(set.cheapest(), 1U);
  EXPECT_EQ(set.CheaperThan(4), TransportSet{1});
  EXPECT_TRUE(set.CheaperThan(1).empty());
  EXPECT_EQ(set.Without(TransportSet{1}).cheapest(), 4U);
  EXPECT_EQ(TransportSet().cheapest(), std::nullopt);
}

class PeerTransportsOfOne : public testing::Test, public conformance::Listener {
 protected:
  static PeerInfo On(const std::string& host) {
    PeerInfo info;
    info.id = SessionId{7};
    info.host = host;
    return info;
  }
  PeerTransports Ruled(TransportRules rules, bool looks = true) {
    return {list, *this, log, std::move(rules), looks, On("here")};
  }
  static std::string Why(const PeerTransports& transports) {
    const auto list = transports.List();
    return list.size() == 1 ? list[0].transport + ": " + list[0].why : std::to_string(list.size());
  }

  const TransportList list =
      TransportList({Entry("zmq", "ZeroMQ", 2), Entry("shared_memory", "shared memory", 1, TransportReach::kHost)});
  Log log{[](LogLevel, std::string_view) {}};
  const SessionId peer{7};
  const PeerInfo info = On("here");
};

TEST_F(PeerTransportsOfOne, ChannelsWithoutARuleUseOneTransport) {
  PeerTransports transports = Ruled({});
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  EXPECT_FALSE(transports.Claim(peer, "b", kShm));
  EXPECT_TRUE(transports.Claim(peer, "b", kZmq));
}

TEST_F(PeerTransportsOfOne, SharedMemoryIsAwaitedExceptForChannelsThatMayNotUseIt) {
  PeerTransports transports = Ruled({{"ours", kOnlyZmq}});
  transports.Found(peer, kOnlyShm, {{"theirs", kOnlyZmq}});
  EXPECT_FALSE(transports.Claim(peer, "a", kZmq));
  EXPECT_TRUE(transports.Claim(peer, "ours", kZmq));
  EXPECT_TRUE(transports.Claim(peer, "theirs", kZmq));
  EXPECT_FALSE(transports.Claim(peer, "theirs", kShm));
  EXPECT_TRUE(transports.Claim(peer, "a", kShm));
}

TEST_F(PeerTransportsOfOne, SharedMemoryChannelStaysThereWhileOthersUseZeroMq) {
  PeerTransports transports = Ruled({{"ours", kOnlyShm}});
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  EXPECT_FALSE(transports.Claim(peer, "ours", kZmq));
  EXPECT_TRUE(transports.Claim(peer, "ours", kShm));
}

TEST_F(PeerTransportsOfOne, ChannelWithoutACommonTransportUsesNone) {
  PeerTransports transports = Ruled({{"a", kOnlyShm}});
  transports.Found(peer, kOnlyShm, {{"a", kOnlyZmq}});
  EXPECT_FALSE(transports.Claim(peer, "a", kShm));
  EXPECT_FALSE(transports.Claim(peer, "a", kZmq));
  EXPECT_TRUE(transports.Allowed(peer, "a").empty());
}

TEST_F(PeerTransportsOfOne, RulesFollowThePeersAnnouncements) {
  PeerTransports transports = Ruled({});
  EXPECT_FALSE(transports.SetRules(peer, {{"a", kOnlyZmq}})) << "the peer is unknown";
  transports.Found(peer, kOnlyShm, {});
  EXPECT_TRUE(transports.SetRules(peer, {{"a", kOnlyZmq}}));
  EXPECT_FALSE(transports.SetRules(peer, {{"a", kOnlyZmq}}));
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  transports.Lost(peer);
  EXPECT_EQ(transports.Allowed(peer, "a"), list.all());
}

TEST_F(PeerTransportsOfOne, ReasonForTheTransportIsReported) {
  PeerTransports transports = Ruled({});
  (void)transports.Came(info, kZmq);
  EXPECT_EQ(Why(transports), "ZeroMQ: not found on this host");
  transports.Found(peer, kOnlyShm, {});
  EXPECT_EQ(Why(transports), "ZeroMQ: no channel of it is used on this host");
  EXPECT_TRUE(transports.MakePartner(peer, kOnlyShm));
  EXPECT_EQ(Why(transports), "ZeroMQ: shared memory does not reach it yet");
  const PeerTransports::GivenUp given_up = transports.GiveUp(peer);
  EXPECT_EQ(given_up.missing, kOnlyShm);
  EXPECT_TRUE(given_up.matters);
  EXPECT_EQ(given_up.reached_by, kZmq);
  EXPECT_EQ(Why(transports), "ZeroMQ: no transport of this host reaches it");
  (void)transports.Came(info, kShm);
  EXPECT_EQ(Why(transports), "shared memory: same host");
  EXPECT_EQ(came, 1) << "one peer over any transport";

  PeerTransports elsewhere = Ruled({});
  (void)elsewhere.Came(On("there"), kZmq);
  EXPECT_EQ(Why(elsewhere), "ZeroMQ: another host");
  PeerTransports alone = Ruled({}, false);
  (void)alone.Came(info, kZmq);
  EXPECT_EQ(Why(alone), "ZeroMQ: discovery on this host is off");
}

TEST_F(PeerTransportsOfOne, SessionThatExchangesNothingIsGivenUpWithoutAWord) {
  PeerTransports transports = Ruled({});
  EXPECT_FALSE(transports.MakePartner(peer, kOnlyShm)) << "it was not found";
  transports.Found(peer, kOnlyShm, {});
  EXPECT_FALSE(transports.GiveUp(peer).matters);
  transports.Found(peer, kOnlyShm, {});
  (void)transports.Came(info, kZmq);
  EXPECT_FALSE(transports.Claim(peer, "a", kZmq)) << "it may still be a partner";
  EXPECT_TRUE(transports.GiveUpStrangers());
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  EXPECT_TRUE(transports.MakePartner(peer, kOnlyShm));
  EXPECT_FALSE(transports.MakePartner(peer, kOnlyShm)) << "this is known";
  EXPECT_FALSE(transports.GiveUpStrangers());
  EXPECT_TRUE(transports.IsPartner(peer));
  transports.Lost(peer);
  EXPECT_FALSE(transports.IsPartner(peer));
}

TEST_F(PeerTransportsOfOne, LateSharedMemoryTakesOverOneChannelAfterTheOther) {
  PeerTransports transports = Ruled({{"ruled", kOnlyZmq}});
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  EXPECT_FALSE(transports.Came(info, kZmq));
  const auto move = transports.Came(info, kShm);
  ASSERT_TRUE(move);
  EXPECT_FALSE(transports.Claim(peer, "a", kShm)) << "the move is not open yet";
  transports.OpenMove(peer);
  EXPECT_TRUE(transports.Claim(peer, "a", kShm)) << "both during the move";
  EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
  EXPECT_FALSE(transports.Claim(peer, "ruled", kShm));
  transports.Moved(peer, "a");
  EXPECT_FALSE(transports.Claim(peer, "a", kZmq));
  EXPECT_TRUE(transports.Claim(peer, "b", kZmq));
  EXPECT_TRUE(transports.FinishMove(peer, *move));
  EXPECT_FALSE(transports.FinishMove(peer, *move)) << "a move is finished only once";
  EXPECT_FALSE(transports.Claim(peer, "b", kZmq));
  EXPECT_TRUE(transports.Claim(peer, "b", kShm));
  EXPECT_EQ(Why(transports), "shared memory: same host");
}

TEST_F(PeerTransportsOfOne, RemainingTransportGetsAllChannelsWhenTheOtherIsLostDuringAMove) {
  for (const TransportIndex lost : {kShm, kZmq}) {
    PeerTransports transports = Ruled({});
    EXPECT_TRUE(transports.Claim(peer, "a", kZmq));
    EXPECT_FALSE(transports.Came(info, kZmq));
    const auto move = transports.Came(info, kShm);
    ASSERT_TRUE(move);
    transports.OpenMove(peer);
    transports.Moved(peer, "a");
    EXPECT_TRUE(transports.Gone(info, lost, "the connection was closed"));
    EXPECT_EQ(transports.Claim(peer, "a", kZmq), lost == kShm);
    EXPECT_EQ(transports.Claim(peer, "a", kShm), lost == kZmq);
    EXPECT_FALSE(transports.FinishMove(peer, *move));
    EXPECT_FALSE(transports.NextMove(peer));
  }
}

constexpr TransportIndex kLoop = 0;
constexpr TransportIndex kMemory = 1;
constexpr TransportIndex kNetwork = 2;

class ThreeTransportsToOne : public PeerTransportsOfOne {
 protected:
  // Receives over the network first. `rule` applies to the channel "ruled".
  void Start(TransportSet rule) {
    transports.emplace(three, *this, log, TransportRules{{"ruled", rule}}, true, On("here"));
    EXPECT_TRUE(transports->Claim(peer, "a", kNetwork));
    EXPECT_EQ(transports->Claim(peer, "ruled", kNetwork), rule.Has(kNetwork));
    EXPECT_FALSE(transports->Came(info, kNetwork));
  }
  [[nodiscard]] std::string TakenBy(const std::string& channel) {
    std::string names;
    for (TransportIndex i = 0; i < three.size(); ++i) {
      const bool asks = transports->ReachedBy(peer).Has(i);
      if (asks && transports->Claim(peer, channel, i)) names += three[i].key + " ";
    }
    return names;
  }

  const TransportList three = TransportList({Entry("zmq", "ZeroMQ", 3, TransportReach::kNetwork),
                                             Entry("loop", "a loop", 1, TransportReach::kHost),
                                             Entry("shared_memory", "shared memory", 2, TransportReach::kHost)});
  std::optional<PeerTransports> transports;
};

TEST_F(ThreeTransportsToOne, CheapestTransportIsUsedWhicheverAsksFirst) {
  transports.emplace(three, *this, log, TransportRules(), true, On("here"));
  transports->Found(peer, {kLoop, kMemory}, {});
  EXPECT_TRUE(transports->MakePartner(peer, {kLoop, kMemory}));
  EXPECT_FALSE(transports->Came(info, kNetwork));
  EXPECT_FALSE(transports->Came(info, kMemory));
  EXPECT_EQ(TakenBy("a"), "") << "it is left to the loop";
  const PeerTransports::GivenUp given_up = transports->GiveUp(peer);
  EXPECT_EQ(given_up.missing, TransportSet{kLoop});
  EXPECT_FALSE(given_up.matters) << "another transport of this host reaches it";
  EXPECT_FALSE(transports->Claim(peer, "a", kNetwork));
  EXPECT_EQ(TakenBy("a"), "shared_memory ");
  EXPECT_EQ(Why(*transports), "shared memory: same host");
}

TEST_F(ThreeTransportsToOne, SecondMoveFollowsTheFirst) {
  Start({kMemory, kNetwork});
  const auto first = transports->Came(info, kMemory);
  ASSERT_TRUE(first);
  transports->OpenMove(peer);
  EXPECT_EQ(TakenBy("a"), "shared_memory zmq ");
  EXPECT_EQ(TakenBy("ruled"), "shared_memory zmq ");
  EXPECT_FALSE(transports->Came(info, kLoop)) << "only after the current move";
  EXPECT_EQ(TakenBy("a"), "shared_memory zmq ");
  EXPECT_FALSE(transports->NextMove(peer));
  EXPECT_TRUE(transports->FinishMove(peer, *first));
  const auto second = transports->NextMove(peer);
  ASSERT_TRUE(second);
  transports->OpenMove(peer);
  EXPECT_FALSE(transports->FinishMove(peer, *first)) << "the first move is over";
  EXPECT_EQ(TakenBy("a"), "loop shared_memory ");
  EXPECT_EQ(TakenBy("ruled"), "shared_memory ") << "the loop is not allowed";
  EXPECT_FALSE(transports->MoveOf(peer, "ruled"));
  EXPECT_TRUE(transports->FinishMove(peer, *second));
  EXPECT_FALSE(transports->NextMove(peer));
  EXPECT_EQ(TakenBy("a"), "loop ");
}

TEST_F(ThreeTransportsToOne, CheapestRemainingTransportTakesOverWhenOneIsLost) {
  Start({kLoop, kNetwork});
  for (const TransportIndex cheaper : {kMemory, kLoop}) {
    const auto move = transports->Came(info, cheaper);
    ASSERT_TRUE(move);
    transports->OpenMove(peer);
    EXPECT_TRUE(transports->FinishMove(peer, *move));
    EXPECT_FALSE(transports->NextMove(peer));
  }
  EXPECT_EQ(TakenBy("a"), "loop ");
  EXPECT_EQ(TakenBy("ruled"), "loop ");
  EXPECT_TRUE(transports->Gone(info, kLoop, "it was closed"));
  EXPECT_FALSE(transports->Claim(peer, "a", kNetwork)) << "shared memory reaches it";
  EXPECT_EQ(TakenBy("a"), "shared_memory ");
  EXPECT_EQ(TakenBy("ruled"), "zmq ");
  EXPECT_TRUE(transports->Gone(info, kMemory, "it was closed"));
  EXPECT_EQ(TakenBy("a"), "zmq ");
  EXPECT_EQ(gone, 0);
  EXPECT_FALSE(transports->Gone(info, kNetwork, "it was closed"));
  EXPECT_EQ(gone, 1);
}

TEST_F(ThreeTransportsToOne, AnotherMoveBeginsWhenTheNewTransportIsLost) {
  Start({kNetwork});
  ASSERT_TRUE(transports->Came(info, kLoop));
  transports->OpenMove(peer);
  EXPECT_FALSE(transports->Came(info, kMemory));
  EXPECT_TRUE(transports->Gone(info, kLoop, "it was closed"));
  EXPECT_EQ(TakenBy("a"), "zmq ");
  EXPECT_TRUE(transports->NextMove(peer));
  transports->OpenMove(peer);
  EXPECT_EQ(TakenBy("a"), "shared_memory zmq ");
}

}  // namespace
}  // namespace hgros::peer_transports_test
