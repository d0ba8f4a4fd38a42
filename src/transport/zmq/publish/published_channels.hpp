#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/control.pb.h"
#include "transport/outbound_core.hpp"
#include "transport/zmq/publish/out_link.hpp"
#include "transport/zmq/publish/subscriber_peer.hpp"
#include "transport/zmq/publish/wire_message.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// The advertised channels as one publish endpoint sees them: which are offered there, the links that carry each, and
/// the plain subscribers. Messages are sent here.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: a link is listed in its channel for as long as its wish owns it. A channel that is not allowed has no
/// links and no plain subscribers.
class PublishedChannels {
 public:
  struct Channel {
    std::shared_ptr<OutboundCore> core;
    bool allowed = true;
    bool plain = false;  ///< There is a plain subscriber.
    std::vector<OutLink*> links;
  };

  PublishedChannels(SharedState& shared, Socket& socket, const ChannelList& allowed);

  Channel& Add(const std::shared_ptr<OutboundCore>& core);
  void Remove(const OutboundCore& core) { channels_.erase(core.name); }
  /// Null if there is none.
  [[nodiscard]] Channel* Find(const std::string& name);
  /// Null if another channel object has that name.
  [[nodiscard]] Channel* Find(const std::shared_ptr<OutboundCore>& core);
  [[nodiscard]] bool IsAllowed(const std::string& channel) const;
  /// Sets which channels are allowed, and returns those for which this changes.
  [[nodiscard]] std::vector<Channel*> SetAllowed(const ChannelList& allowed);
  /// Adds the types of all channels that are offered.
  void AddOffers(google::protobuf::RepeatedPtrField<wire::ChannelType>& offers) const;

  [[nodiscard]] bool HasRoom(const OutboundCore& core) const;
  /// Number of messages that lossless subscribers have not consumed.
  [[nodiscard]] std::size_t Unfinished(const OutboundCore& core) const;
  void Reserve(const OutboundCore& core);
  void CancelReservation(const std::shared_ptr<OutboundCore>& core, Actions& actions);
  void Commit(const std::shared_ptr<OutboundCore>& core, const std::shared_ptr<const WireMessage>& message,
              PeerChannel::Dropped& ended, Actions& actions);
  /// Sends what the link's credit allows.
  void SendWaiting(OutLink& link, PeerChannel::Dropped& ended) {
    link.SendWaiting(socket_, shared_.options.peer_queue_bytes, ended);
  }
  /// Why a link ends.
  enum class LinkEnd {
    kUnsubscribed,
    kWithdrawn,  ///< This session no longer offers the channel. Messages that were not confirmed count as missed.
    kLost,       ///< The subscriber has gone, or misses messages. They count as missed, and this is logged.
  };
  /// Ends the link of a wish of this peer, if it has one.
  void RemoveLink(const SubscriberPeer& peer, Wish& wish, LinkEnd why, Actions& actions);

  /// The bytes that ZeroMQ holds for plain subscribers.
  [[nodiscard]] std::uint64_t plain_bytes() const { return plain_bytes_->load(std::memory_order_relaxed); }
  /// Whether plain subscribers may soon lose messages because one of them does not read.
  [[nodiscard]] bool IsPlainSlow(const OutboundCore& core) const {
    if (plain_bytes() <= shared_.options.plain_queue_bytes / 2) return false;
    const auto found = channels_.find(core.name);
    return found != channels_.end() && found->second.plain;
  }
  /// A plain subscriber has come to the channel, or the last one has gone.
  void SetPlainTopic(std::string_view channel, bool subscribed, std::string_view endpoint, Actions& actions);
  /// Counts the plain subscribers of the channel if that has changed.
  void UpdatePlain(Channel& channel, Actions& actions);

 private:
  SharedState& shared_;
  Socket& socket_;
  std::optional<std::set<std::string, std::less<>>> allowed_;
  std::unordered_map<std::string, Channel> channels_;
  std::set<std::string, std::less<>> plain_topics_;  // Names of channels that plain subscribers ask for.
  const OutstandingBytes plain_bytes_ = std::make_shared<std::atomic<std::uint64_t>>(0);
};

}  // namespace hgros::zmq
