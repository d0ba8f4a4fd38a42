#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hgros/control.pb.h"
#include "transport/zmq/publish/published_channels.hpp"
#include "transport/zmq/publish/subscriber_peers.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// Joins the wishes of peers with the channels that are offered at one publish endpoint: makes, resumes and ends the
/// links, and sends their first messages.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: a link belongs to a peer's wish and to an offered channel of the same name whose type fits.
class Subscriptions {
 public:
  /// A link was made whose latched messages have to be fetched without the mutex, and passed to BeginLink().
  using FetchLatched =
      std::function<void(const std::shared_ptr<OutboundCore>& core, SessionId session, std::uint64_t link)>;

  Subscriptions(SharedState& shared, PublishedChannels& channels, SubscriberPeers& peers, FetchLatched fetch_latched)
      : shared_(shared), channels_(channels), peers_(peers), fetch_latched_(std::move(fetch_latched)) {}

  /// The channel is now offered: makes the links that peers wait for.
  void OpenChannel(PublishedChannels::Channel& channel, Actions& actions);
  /// The channel is no longer offered: ends its links.
  void CloseChannel(PublishedChannels::Channel& channel, Actions& actions);
  /// Sends the latched messages, then what has been published since the link was made.
  void BeginLink(const OutboundCore& core, SessionId session, std::uint64_t link, std::vector<PendingMessage>&& latched,
                 PeerChannel::Dropped& ended);

  /// `connection`: the descriptor that it came over.
  void OnSubscribe(SubscriberPeer& peer, const wire::Subscribe& asked, int connection, Actions& actions);
  void OnUnsubscribe(SubscriberPeer& peer, const wire::Unsubscribe& unsubscribe, int connection, Actions& actions);
  void OnCredit(SubscriberPeer& peer, const wire::Credit& credit, Actions& actions);

 private:
  /// False if the link has ended instead, because it cannot continue from the subscriber's state.
  [[nodiscard]] bool UpdateLink(SubscriberPeer& peer, Wish& wish, Actions& actions);
  void MakeLink(SubscriberPeer& peer, Wish& wish, Actions& actions);
  void SendSubscribed(const SubscriberPeer& peer, const Wish& wish, const std::string& descriptor_set);
  [[nodiscard]] Demand GrantedTo(const OutboundCore& core, const wire::Subscribe& asked) const;

  SharedState& shared_;
  PublishedChannels& channels_;
  SubscriberPeers& peers_;
  const FetchLatched fetch_latched_;
};

}  // namespace hgros::zmq
