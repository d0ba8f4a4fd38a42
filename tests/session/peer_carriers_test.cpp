#include "session/peer_carriers.hpp"

#include <gtest/gtest.h>

namespace hgros {
namespace {

constexpr auto kShm = CarrierKind::kShm;
constexpr auto kZmq = CarrierKind::kZmq;
constexpr CarrierSet kOnlyShm{true, false};
constexpr CarrierSet kOnlyZmq{false, true};

class PeerCarriersOfOne : public testing::Test, public TransportListener {
 protected:
  void OnPeerCame(const PeerInfo& /*info*/) noexcept override { ++came; }
  void OnPeerGone(const PeerInfo& /*info*/, std::string_view /*reason*/) noexcept override { ++gone; }
  void OnTypeMismatch(std::string_view /*channel*/, const PeerInfo& /*info*/,
                      std::string_view /*what*/) noexcept override {}

  static PeerInfo On(const std::string& host) {
    PeerInfo info;
    info.id = SessionId{7};
    info.host = host;
    return info;
  }
  PeerCarriers Ruled(CarrierRules rules, bool looks = true) { return {*this, log, std::move(rules), looks, "here"}; }
  static std::string Why(const PeerCarriers& carriers) {
    const auto list = carriers.List();
    return list.size() == 1 ? list[0].carrier + ": " + list[0].why : std::to_string(list.size());
  }

  Log log{[](LogLevel, std::string_view) {}};
  const SessionId peer{7};
  const PeerInfo info = On("here");
  int came = 0;
  int gone = 0;
};

TEST_F(PeerCarriersOfOne, OneCarrierHasAllChannelsOfNoRule) {
  PeerCarriers carriers = Ruled({});
  EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
  EXPECT_FALSE(carriers.Take(peer, "b", kShm));
  EXPECT_TRUE(carriers.Take(peer, "b", kZmq));
}

TEST_F(PeerCarriersOfOne, AnExpectedOneIsLeftToSharedMemoryButForWhatMayNotPassThere) {
  PeerCarriers carriers = Ruled({{"ours", kOnlyZmq}});
  carriers.Found(peer, true, {{"theirs", kOnlyZmq}});
  EXPECT_FALSE(carriers.Take(peer, "a", kZmq));
  EXPECT_TRUE(carriers.Take(peer, "ours", kZmq));
  EXPECT_TRUE(carriers.Take(peer, "theirs", kZmq));
  EXPECT_FALSE(carriers.Take(peer, "theirs", kShm));
  EXPECT_TRUE(carriers.Take(peer, "a", kShm));
}

TEST_F(PeerCarriersOfOne, WhatIsForSharedMemoryStaysThereWhateverCarriesTheRest) {
  PeerCarriers carriers = Ruled({{"ours", kOnlyShm}});
  EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
  EXPECT_FALSE(carriers.Take(peer, "ours", kZmq));
  EXPECT_TRUE(carriers.Take(peer, "ours", kShm));
}

TEST_F(PeerCarriersOfOne, WhatHasNothingInCommonTakesNoCarrier) {
  PeerCarriers carriers = Ruled({{"a", kOnlyShm}});
  carriers.Found(peer, true, {{"a", kOnlyZmq}});
  EXPECT_FALSE(carriers.Take(peer, "a", kShm));
  EXPECT_FALSE(carriers.Take(peer, "a", kZmq));
  EXPECT_TRUE(carriers.Allowed(peer, "a").none());
}

TEST_F(PeerCarriersOfOne, RulesChangeWithWhatIsAnnounced) {
  PeerCarriers carriers = Ruled({});
  EXPECT_FALSE(carriers.SetRules(peer, {{"a", kOnlyZmq}})) << "nobody is known";
  carriers.Found(peer, true, {});
  EXPECT_TRUE(carriers.SetRules(peer, {{"a", kOnlyZmq}}));
  EXPECT_FALSE(carriers.SetRules(peer, {{"a", kOnlyZmq}}));
  EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
  carriers.Lost(peer);
  EXPECT_TRUE(carriers.Allowed(peer, "a").all());
}

TEST_F(PeerCarriersOfOne, TheReasonForACarrierIsSaid) {
  PeerCarriers carriers = Ruled({});
  (void)carriers.Came(info, kZmq);
  EXPECT_EQ(Why(carriers), "ZeroMQ: not found on this host");
  carriers.Found(peer, true, {});
  EXPECT_EQ(Why(carriers), "ZeroMQ: shared memory does not reach it yet");
  EXPECT_EQ(carriers.GiveUp(peer), PeerCarriers::Without::kReached);
  EXPECT_EQ(Why(carriers), "ZeroMQ: no memory can be shared with it");
  (void)carriers.Came(info, kShm);
  EXPECT_EQ(Why(carriers), "shared memory: same host");
  EXPECT_EQ(came, 1) << "one peer, whatever reaches it";

  PeerCarriers elsewhere = Ruled({});
  (void)elsewhere.Came(On("there"), kZmq);
  EXPECT_EQ(Why(elsewhere), "ZeroMQ: another host");
  PeerCarriers alone = Ruled({}, false);
  (void)alone.Came(info, kZmq);
  EXPECT_EQ(Why(alone), "ZeroMQ: sessions of this host are not looked for");
}

TEST_F(PeerCarriersOfOne, LateSharedMemoryGetsOneChannelAfterTheOther) {
  PeerCarriers carriers = Ruled({{"ruled", kOnlyZmq}});
  EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
  EXPECT_FALSE(carriers.Came(info, kZmq));
  EXPECT_TRUE(carriers.Came(info, kShm));
  EXPECT_TRUE(carriers.Take(peer, "a", kShm)) << "both, for a while";
  EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
  EXPECT_FALSE(carriers.Take(peer, "ruled", kShm));
  carriers.Moved(peer, "a");
  EXPECT_FALSE(carriers.Take(peer, "a", kZmq));
  EXPECT_TRUE(carriers.Take(peer, "b", kZmq));
  EXPECT_TRUE(carriers.FinishMove(peer));
  EXPECT_FALSE(carriers.FinishMove(peer)) << "once";
  EXPECT_FALSE(carriers.Take(peer, "b", kZmq));
  EXPECT_TRUE(carriers.Take(peer, "b", kShm));
  EXPECT_EQ(Why(carriers), "shared memory: same host");
}

TEST_F(PeerCarriersOfOne, WhatRemainsInTheMiddleOfAMoveHasAllChannels) {
  for (const CarrierKind lost : {kShm, kZmq}) {
    PeerCarriers carriers = Ruled({});
    EXPECT_TRUE(carriers.Take(peer, "a", kZmq));
    EXPECT_FALSE(carriers.Came(info, kZmq));
    EXPECT_TRUE(carriers.Came(info, kShm));
    carriers.Moved(peer, "a");
    EXPECT_TRUE(carriers.Gone(info, lost, "the connection was closed"));
    EXPECT_EQ(carriers.Take(peer, "a", kZmq), lost == kShm);
    EXPECT_EQ(carriers.Take(peer, "a", kShm), lost == kZmq);
    EXPECT_FALSE(carriers.FinishMove(peer));
  }
}

}  // namespace
}  // namespace hgros
