#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// The link of one channel to one subscribing session.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariant: the link's waiting bytes are part of the sums of its peer and of its channel until LeaveSums().
class OutLink {
 public:
  /// `peer_waiting_bytes` is the sum of all links to that session, and outlives the link.
  OutLink(std::shared_ptr<OutboundCore> channel, const Demand& granted, SessionId session,
          std::uint64_t& peer_waiting_bytes);

  /// Sends what the credit allows. Then a keep-last link drops messages above its queue depth, or above
  /// `peer_limit_bytes` for the whole session. Messages that are no longer needed go to `ended`.
  void SendWaiting(Socket& socket, std::uint64_t peer_limit_bytes, PeerChannel::Dropped& ended);
  void Pause(SteadyTime now);
  [[nodiscard]] bool IsPausedSince(SteadyTime when) const noexcept { return flow.paused() && paused_since_ < when; }
  /// The link has ended: removes its bytes from the sums.
  void LeaveSums();

  const SessionId subscriber;
  const std::shared_ptr<OutboundCore> core;
  const std::uint64_t id;
  PeerChannel flow;

 private:
  void CountWaiting();

  std::string topic_;  // The last 8 bytes are the message's number.
  std::uint64_t& peer_waiting_bytes_;
  std::uint64_t counted_bytes_ = 0;  // The part of flow.unsent_bytes() that is in both sums.
  SteadyTime paused_since_{};
};

}  // namespace hgros::zmq
