#pragma once

#include <string>
#include <string_view>

#include "hgros/transport/peer_info.hpp"

namespace hgros {

/// A session came or went, uses a channel with another type, or serves a name that another session serves. Published
/// inside the process on kPeerEventsChannel: session.FromGraph<PeerEvent>(kPeerEventsChannel, ...). Subscribe first,
/// then call Session::Peers() for the sessions that came earlier.
struct PeerEvent {
  enum class Kind { kCame, kGone, kTypeMismatch, kServedTwice };
  Kind kind = Kind::kCame;
  PeerInfo peer;
  std::string channel;  ///< For kTypeMismatch; the channel of the requests for kServedTwice.
  std::string reason;   ///< A sentence, with the fix if there is one; empty for kCame.
};

inline constexpr std::string_view kPeerEventsChannel = "hgros/peers";

}  // namespace hgros
