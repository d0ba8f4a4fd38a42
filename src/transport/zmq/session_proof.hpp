#pragma once

#include <array>
#include <cstdint>

#include "hgros/base/ids.hpp"

namespace hgros::zmq {

/// The key of a session's proofs.
using ProofKey = std::array<std::uint64_t, 2>;

/// What a session with this key proves with to this publisher that a Hello is its own: SipHash-2-4 of the publisher's
/// id (https://www.aumasson.jp/siphash/siphash.pdf), or 1 for 0. One publisher does not learn the proof for another,
/// even if it asks for many.
[[nodiscard]] std::uint64_t SessionProof(const ProofKey& key, SessionId publisher) noexcept;

}  // namespace hgros::zmq
