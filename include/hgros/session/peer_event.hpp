#pragma once

#include <string>
#include <string_view>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// A session came, went, or does not fit. Published inside the process on kPeerEventsChannel:
/// session.FromGraph<PeerEvent>(kPeerEventsChannel, ...). Who came before that is in Session::Peers(): ask for it after
/// subscribing.
struct PeerEvent {
  enum class Kind { kCame, kGone, kTypeMismatch };
  Kind kind = Kind::kCame;
  PeerInfo peer;
  std::string channel;  ///< Only for kTypeMismatch.
  std::string reason;   ///< In words, for kTypeMismatch with the mend; empty for kCame.
};

inline constexpr std::string_view kPeerEventsChannel = "hgros/peers";

}  // namespace hgros
