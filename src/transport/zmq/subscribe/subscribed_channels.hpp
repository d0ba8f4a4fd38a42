#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>

#include "hgros/control.pb.h"
#include "transport/inbound_core.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/subscribe/in_link.hpp"
#include "transport/zmq/subscribe/publisher_connection.hpp"
#include "transport/zmq/subscribe/remote_publisher.hpp"

namespace hgros::zmq {

/// The claim to the channel of `core` is free now; to several, if it is null.
using ClaimsFreed = std::function<void(const InboundCore* core)>;

/// The subscribed channels as one subscribe endpoint sees them: the wishes to the publisher, its answers, and the
/// credit that it gets.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: a channel is asked for only while this endpoint has the claim to it (InboundCore::Claim), and while the
/// publisher is alive.
class SubscribedChannels {
 public:
  /// `claims_freed` is called without a lock when channels may be asked for at another endpoint.
  SubscribedChannels(SharedState& shared, PublisherConnection& connection, RemotePublisher& publisher,
                     const ChannelList& allowed, ClaimsFreed claims_freed);

  void Add(const std::shared_ptr<InboundCore>& core);
  void Remove(const std::shared_ptr<InboundCore>& core);
  void UpdateDemand(const InboundCore& core);
  void SetAllowed(const ChannelList& allowed, Actions& actions);
  /// Null if there is none.
  [[nodiscard]] InLink* Find(const std::string& channel) {
    const auto found = links_.find(channel);
    return found == links_.end() ? nullptr : &found->second;
  }

  /// Asks for all channels, in answer to a Welcome.
  void AskForAll();
  /// Asks for channels whose claims are free now, and drops those that must come over another transport. Only that of
  /// `core`, if it is not null.
  void AskAgain(const InboundCore* core, Actions& actions);
  void DropAll(Actions& actions);
  void SetPlain(bool plain);

  void OnSubscribed(const wire::Subscribed& subscribed, Actions& actions);
  void OnRefused(const wire::Refused& refused, Actions& actions);
  void OnWithdrawn(const std::string& channel, Actions& actions);
  /// The publisher cannot be reached. Unless `for_good`, its links may later continue where they were cut. True if
  /// this has freed claims.
  [[nodiscard]] bool OnPublisherLost(bool for_good, Actions& actions);
  void AddClaimsFreed(Actions& actions) const {
    actions.emplace_back([freed = claims_freed_] { freed(nullptr); });
  }

  /// Whether a publisher waits for credit, or soon will. Thread-safe.
  [[nodiscard]] bool IsCreditDue() const noexcept { return !due_->empty(); }
  /// Sends the credit for what was consumed since the last Credit: of the links whose credit is due, or of all.
  void SendCredit(bool all);

 private:
  [[nodiscard]] bool IsAllowed(const std::string& channel) const;
  void SetPlain(InLink& link, bool plain);
  void Ask(InLink& link);
  void AskAgain(InLink& link, Actions& actions);
  void SetAsked(InLink& link, bool asked);
  void SendSubscribe(InLink& link, bool change_only);
  void SendUnsubscribe(const std::string& channel, std::string_view mismatch);
  void StopAsking(InLink& link, std::string_view mismatch, Actions& actions);
  /// False if the types do not fit, which ends the subscription here.
  [[nodiscard]] bool BeginLink(InLink& link, const wire::Subscribed& subscribed, Actions& actions);
  void EndLink(InLink& link, Actions& actions, OfferEnd why = OfferEnd::kLost);
  void SendCredit(InLink& link);
  void ReleaseClaim(const InLink& link, Actions& actions);
  /// Another endpoint that leads to the same socket has the claim.
  [[nodiscard]] bool IsClaimedBeside(const InLink& link) const;
  void ReportMismatch(const std::string& channel, const std::string& what, Actions& actions);

  SharedState& shared_;
  PublisherConnection& connection_;
  RemotePublisher& publisher_;
  const ClaimsFreed claims_freed_;
  std::optional<std::set<std::string, std::less<>>> allowed_;
  const std::shared_ptr<DueCredits> due_;
  std::unordered_map<std::string, InLink> links_;
  std::size_t asked_ = 0;  // Links with `asked`.
};

}  // namespace hgros::zmq
