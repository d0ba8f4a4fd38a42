#pragma once

#include <string>
#include <string_view>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// A session came, went, does not fit, or serves a name that another one serves. Published inside the process on
/// kPeerEventsChannel: session.FromGraph<PeerEvent>(kPeerEventsChannel, ...). Subscribe first, then ask
/// Session::Peers() for the sessions that came before.
struct PeerEvent {
  enum class Kind { kCame, kGone, kTypeMismatch, kServedTwice };
  Kind kind = Kind::kCame;
  PeerInfo peer;
  std::string channel;  ///< For kTypeMismatch; the channel of the requests for kServedTwice.
  std::string reason;   ///< In words, with how to mend it if that is possible; empty for kCame.
};

inline constexpr std::string_view kPeerEventsChannel = "hgros/peers";

}  // namespace hgros
