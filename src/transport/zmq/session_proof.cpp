#include "transport/zmq/session_proof.hpp"

#include <bit>

namespace hgros::zmq {
namespace {

struct SipState {
  std::uint64_t v0, v1, v2, v3;

  void Round() noexcept {
    v0 += v1;
    v1 = std::rotl(v1, 13) ^ v0;
    v0 = std::rotl(v0, 32);
    v2 += v3;
    v3 = std::rotl(v3, 16) ^ v2;
    v0 += v3;
    v3 = std::rotl(v3, 21) ^ v0;
    v2 += v1;
    v1 = std::rotl(v1, 17) ^ v2;
    v2 = std::rotl(v2, 32);
  }
  void Add(std::uint64_t word) noexcept {
    v3 ^= word;
    Round();
    Round();
    v0 ^= word;
  }
};

}  // namespace

std::uint64_t SessionProof(const ProofKey& key, SessionId publisher) noexcept {
  SipState state{key[0] ^ 0x736f6d6570736575U, key[1] ^ 0x646f72616e646f6dU, key[0] ^ 0x6c7967656e657261U,
                 key[1] ^ 0x7465646279746573U};
  state.Add(publisher.value);
  state.Add(std::uint64_t{sizeof publisher.value} << 56U);  // The last word has the length, and no bytes are left.
  state.v2 ^= 0xff;
  for (int i = 0; i < 4; ++i) state.Round();
  const std::uint64_t proof = state.v0 ^ state.v1 ^ state.v2 ^ state.v3;
  return proof == 0 ? 1 : proof;  // 0 is the proof of versions without proofs.
}

}  // namespace hgros::zmq
