#include <gtest/gtest.h>

#include <string>

#include "conformance/transport_conformance.hpp"
#include "transport/zmq/session_keys.hpp"

namespace hgros::zmq {
namespace {

TEST(ZmqSessionKeys, ASessionBelongsToItsFirstKey) {
  conformance::Listener listener;
  const PeerRegistry peers(listener);
  SessionKeys keys(peers, {1}, "own");
  EXPECT_TRUE(keys.Claim({1}, "own"));
  EXPECT_FALSE(keys.Claim({1}, "other"));
  EXPECT_TRUE(keys.Claim({2}, "first"));
  EXPECT_FALSE(keys.Claim({2}, "second"));
  EXPECT_FALSE(keys.Claim({2}, ""));
  EXPECT_TRUE(keys.Claim({2}, "first"));
  EXPECT_TRUE(keys.Claim({3}, "first")) << "sessions may share a key";
}

TEST(ZmqSessionKeys, ManyInventedSessionsDoNotFreeAConnectedOne) {
  conformance::Listener listener;
  PeerRegistry peers(listener);
  SessionKeys keys(peers, {1}, "own");
  PeerInfo connected;
  connected.id = {2};
  peers.Came(connected);
  EXPECT_TRUE(keys.Claim(connected.id, "first"));
  for (std::uint64_t id = 10; id < 30'000; ++id) EXPECT_TRUE(keys.Claim({id}, "inventor"));
  EXPECT_FALSE(keys.Claim(connected.id, "inventor"));
  EXPECT_FALSE(keys.Claim({1}, "inventor"));
  EXPECT_TRUE(keys.Claim({10}, "another")) << "it was forgotten";
}

}  // namespace
}  // namespace hgros::zmq
