#include <gtest/gtest.h>

#include <cstdint>
#include <set>

#include "conformance/transport_conformance.hpp"
#include "hgros/base/log.hpp"
#include "transport/zmq/session_proof.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {
namespace {

// vectors_sip64 of the reference implementation: key 00 01 ... 0f, input 00 01 ... 07.
TEST(ZmqSessionProof, IsSipHashOfThePublishersId) {
  EXPECT_EQ(SessionProof({0x0706050403020100, 0x0f0e0d0c0b0a0908}, SessionId{0x0706050403020100}), 0x93f5f5799a932462U);
}

TEST(ZmqSessionProof, StaysTheSameHoweverManyPublishersThereAre) {
  conformance::Listener listener;
  Log log{[](LogLevel, std::string_view) {}};
  const SharedState shared({}, listener, log);
  const std::uint64_t first = shared.ProofFor(SessionId{1});
  std::set<std::uint64_t> all{first};
  for (std::uint64_t id = 2; id <= 10'000; ++id) all.insert(shared.ProofFor(SessionId{id}));
  EXPECT_EQ(shared.ProofFor(SessionId{1}), first);
  EXPECT_EQ(all.size(), 10'000U) << "each has its own";
  const SharedState other({}, listener, log);
  EXPECT_NE(other.ProofFor(SessionId{1}), first);
}

}  // namespace
}  // namespace hgros::zmq
