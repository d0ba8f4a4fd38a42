#pragma once

#include <algorithm>
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
                     const ChannelList& allowed, std::function<void()> claims_freed);

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
  /// Asks for channels whose claims are free now, and drops those that must come over another transport.
  void AskAgain(Actions& actions);
  void DropAll(Actions& actions);
  void SetPlain(bool plain);

  void OnSubscribed(const wire::Subscribed& subscribed, Actions& actions);
  void OnRefused(const wire::Refused& refused, Actions& actions);
  void OnWithdrawn(const std::string& channel, Actions& actions);
  /// The publisher cannot be reached. Unless `for_good`, its links may later continue where they were cut. True if
  /// this has freed claims.
  [[nodiscard]] bool OnPublisherLost(bool for_good, Actions& actions);
  void AddClaimsFreed(Actions& actions) { actions.emplace_back(claims_freed_); }

  /// Whether the publisher waits for credit. Answers wake-ups.
  [[nodiscard]] bool IsCreditDue() {
    return std::ranges::any_of(links_,
                               [](auto& entry) { return entry.second.id != 0 && entry.second.credit->AnswerWake(); });
  }
  /// Sends the credit for everything that was consumed since the last Credit.
  void SendCredit();

 private:
  [[nodiscard]] bool IsAllowed(const std::string& channel) const;
  void SetPlain(InLink& link, bool plain);
  void Ask(InLink& link);
  void SendSubscribe(InLink& link, bool change_only);
  void SendUnsubscribe(const std::string& channel, std::string_view mismatch);
  void StopAsking(InLink& link, std::string_view mismatch, Actions& actions);
  /// False if the types do not fit, which ends the subscription here.
  [[nodiscard]] bool BeginLink(InLink& link, const wire::Subscribed& subscribed, Actions& actions);
  void EndLink(InLink& link, Actions& actions);
  void ReleaseClaim(const InLink& link, Actions& actions);
  /// Another endpoint that leads to the same socket has the claim.
  [[nodiscard]] bool IsClaimedBeside(const InLink& link) const;
  void ReportMismatch(const std::string& channel, const std::string& what, Actions& actions);

  SharedState& shared_;
  PublisherConnection& connection_;
  RemotePublisher& publisher_;
  const std::function<void()> claims_freed_;
  std::optional<std::set<std::string, std::less<>>> allowed_;
  std::unordered_map<std::string, InLink> links_;
};

}  // namespace hgros::zmq
