#pragma once

#include <string>
#include <string_view>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// A session came, went, does not fit, or serves a name that another one serves. Published inside the process on
/// kPeerEventsChannel: session.FromGraph<PeerEvent>(kPeerEventsChannel, ...). Who came before that is in
/// Session::Peers(): ask for it after subscribing.
struct PeerEvent {
  enum class Kind { kCame, kGone, kTypeMismatch, kServedTwice };
  Kind kind = Kind::kCame;
  PeerInfo peer;
  std::string channel;  ///< For kTypeMismatch; the channel of the requests for kServedTwice.
  std::string reason;   ///< In words, with the mend if there is one; empty for kCame.
};

inline constexpr std::string_view kPeerEventsChannel = "hgros/peers";

}  // namespace hgros
