#include "transport/zmq/publish/subscriptions.hpp"

#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"

namespace hgros::zmq {
namespace {

/// The Welcomes of an endpoint are numbered from a random number.
bool IsOlder(std::uint64_t handshake, std::uint64_t other) { return static_cast<std::int64_t>(handshake - other) < 0; }

/// Makes sure that the messages are destroyed when no mutex is held.
void EndLater(PeerChannel::Dropped&& messages, Actions& actions) {
  if (!messages.empty()) actions.emplace_back([ended = std::move(messages)] {});
}

}  // namespace

Demand Subscriptions::GrantedTo(const OutboundCore& core, const wire::Subscribe& asked) const {
  return PeerChannel::Granted({.lossless = asked.lossless() && core.may_promise,
                               .queue_depth = asked.queue_depth(),
                               .credit_messages = asked.credit_messages(),
                               .credit_bytes = asked.credit_bytes()},
                              shared_.options.max_credit_bytes);
}

void Subscriptions::OpenChannel(PublishedChannels::Channel& channel, Actions& actions) {
  peers_.AnnounceOffer(*channel.core, true);
  channels_.UpdatePlain(channel, actions);
  for (SubscriberPeer* peer : peers_.FindWaiting(channel.core->name)) {
    MakeLink(*peer, peer->wishes.at(channel.core->name), actions);
  }
}

void Subscriptions::CloseChannel(PublishedChannels::Channel& channel, Actions& actions) {
  peers_.AnnounceOffer(*channel.core, false);
  if (std::exchange(channel.plain, false)) OutboundCore::CountSubscriber(channel.core, {}, -1, actions);
  while (!channel.links.empty()) {
    SubscriberPeer& peer = *peers_.Find(channel.links.back()->subscriber);
    auto message = ControlFrom(shared_.self.info.id);
    message.mutable_withdrawn()->set_channel(channel.core->name);
    peers_.Send(peer, message);
    channels_.RemoveLink(peer, peer.wishes.at(channel.core->name), PublishedChannels::LinkEnd::kWithdrawn, actions);
  }
}

void Subscriptions::OnSubscribe(SubscriberPeer& peer, const wire::Subscribe& asked, int connection, Actions& actions) {
  if (IsOlder(asked.handshake(), peer.handshake)) return;
  const std::string& name = asked.wanted().channel();
  if (!ChannelNameFault(name).empty() || asked.wanted().type_name().size() > kMaxTypeNameBytes ||
      (peer.wishes.size() >= kMaxChannels && !peer.wishes.contains(name))) {
    shared_.CountPeerFault(PacketFault::kHead, peer.name(), "an invalid subscription");
    return;
  }
  if (!peer.wishes.contains(name)) shared_.AddChannelsChanged(actions);
  const auto [place, added] = peer.wishes.try_emplace(name);
  Wish& wish = place->second;
  if (!added) peer.wish_bytes -= wish.size();
  // It answers a Welcome that has not paused the link.
  const bool goes_on =
      wish.link && !wish.link->flow.paused() && !asked.change_only() && wish.asked.handshake() != asked.handshake();
  const bool known = wish.link && asked.link() == wish.link->id;
  wish.asked = asked;
  wish.connection = connection;
  if (goes_on && known) wish.asked.set_change_only(true);  // It gets all that was sent.
  peer.wish_bytes += wish.size();
  if (goes_on && !known) {
    peers_.BeginAgain(peer, peer.connection);  // It may not have read about the link yet.
    return;
  }
  if (!wish.link || !UpdateLink(peer, wish, actions)) MakeLink(peer, wish, actions);
}

bool Subscriptions::UpdateLink(SubscriberPeer& peer, Wish& wish, Actions& actions) {
  OutLink& link = *wish.link;
  const wire::Subscribe& asked = wish.asked;
  const Demand granted = GrantedTo(*link.core, asked);
  std::string descriptor_set;
  if (!asked.change_only()) {
    std::optional<std::uint64_t> lost;
    if (asked.link() == link.id) {
      lost = link.flow.Resume(asked.received_messages(), asked.received_bytes());
    } else if (asked.link() == 0 && granted.lossless && link.flow.lossless()) {
      // The connection ended before our Subscribed was read. The messages that were promised on the link since then
      // must still be sent.
      if (auto schema = SchemaFor(asked.wanted(), link.core->type)) {
        lost = link.flow.Resume(0, 0);
        descriptor_set = std::move(*schema);
      }
    }
    if (!lost) {
      channels_.RemoveLink(peer, wish, PublishedChannels::LinkEnd::kLost, actions);
      return false;
    }
    link.core->dropped.fetch_add(*lost, std::memory_order_relaxed);
  }
  if (link.flow.lossless() != granted.lossless) link.core->lossless.fetch_add(granted.lossless ? 1 : std::size_t(-1));
  PeerChannel::Dropped ended;
  link.core->dropped.fetch_add(link.flow.SetDemand(granted, ended), std::memory_order_relaxed);
  SendSubscribed(peer, wish, descriptor_set);
  channels_.SendWaiting(link, ended);
  EndLater(std::move(ended), actions);
  OutboundCore::TellRoom(link.core, actions);
  return true;
}

void Subscriptions::MakeLink(SubscriberPeer& peer, Wish& wish, Actions& actions) {
  const auto& wanted = wish.asked.wanted();
  auto message = ControlFrom(shared_.self.info.id);
  PublishedChannels::Channel* channel = channels_.Find(wanted.channel());
  if (channel == nullptr || !channel->allowed) {
    // The subscriber may have asked because an earlier Welcome offered the channel.
    message.mutable_withdrawn()->set_channel(wanted.channel());
    peers_.Send(peer, message);
    return;
  }
  const auto& core = channel->core;
  const auto descriptor_set = SchemaFor(wanted, core->type);
  if (!descriptor_set) {
    const std::string what = DescribeMismatch(wanted, peer.facts.info, core->type, shared_.self.info, false);
    WriteType(core->name, core->type, *message.mutable_refused()->mutable_offered());
    message.mutable_refused()->set_reason(what);
    peers_.Send(peer, message);
    peers_.ReportMismatch(peer, core->name, what, actions);
    return;
  }
  const SessionId session = peer.facts.info.id;
  wish.link = std::make_unique<OutLink>(core, GrantedTo(*core, wish.asked), session, peer.waiting_bytes);
  channel->links.push_back(wish.link.get());
  if (wish.link->flow.lossless()) core->lossless.fetch_add(1);
  OutboundCore::CountSubscriber(core, session, 1, actions);
  SendSubscribed(peer, wish, *descriptor_set);
  if (peer.cut) wish.link->Pause(std::chrono::steady_clock::now());
  actions.emplace_back([this, core, session, link = wish.link->id] { fetch_latched_(core, session, link); });
}

void Subscriptions::BeginLink(const OutboundCore& core, SessionId session, std::uint64_t link,
                              std::vector<PendingMessage>&& latched, PeerChannel::Dropped& ended) {
  SubscriberPeer* peer = peers_.Find(session);
  if (peer == nullptr) return;
  const auto wish = peer->wishes.find(core.name);
  if (wish == peer->wishes.end() || !wish->second.link || wish->second.link->id != link) return;
  wish->second.link->flow.Begin(std::move(latched));
  channels_.SendWaiting(*wish->second.link, ended);
}

void Subscriptions::SendSubscribed(const SubscriberPeer& peer, const Wish& wish, const std::string& descriptor_set) {
  const OutLink& link = *wish.link;
  auto message = ControlFrom(shared_.self.info.id);
  auto& subscribed = *message.mutable_subscribed();
  WriteType(link.core->name, link.core->type, *subscribed.mutable_offered());
  subscribed.set_link(link.id);
  subscribed.set_next_message(link.flow.sent() + 1);
  subscribed.set_credit_messages(link.flow.demand().credit_messages);
  subscribed.set_credit_bytes(link.flow.demand().credit_bytes);
  subscribed.set_descriptor_set(descriptor_set);
  subscribed.set_wish(wish.asked.wish());
  peers_.Send(peer, message);
}

void Subscriptions::OnUnsubscribe(SubscriberPeer& peer, const wire::Unsubscribe& unsubscribe, int connection,
                                  Actions& actions) {
  const auto wish = peer.wishes.find(unsubscribe.channel());
  if (wish == peer.wishes.end()) return;
  // It asks over another connection by now: the two messages have overtaken each other.
  if (wish->second.connection != connection && peers_.IsAt(peer, wish->second.connection)) return;
  const bool linked = wish->second.link != nullptr;
  channels_.RemoveLink(peer, wish->second, PublishedChannels::LinkEnd::kUnsubscribed, actions);
  if (linked && !unsubscribe.mismatch().empty()) {
    peers_.ReportMismatch(peer, wish->first, Readable(unsubscribe.mismatch(), kMaxTextBytes), actions);
  }
  peer.wish_bytes -= wish->second.size();
  peer.wishes.erase(wish);
  shared_.AddChannelsChanged(actions);
}

void Subscriptions::OnCredit(SubscriberPeer& peer, const wire::Credit& credit, Actions& actions) {
  const auto wish = peer.wishes.find(credit.channel());
  if (wish == peer.wishes.end() || !wish->second.link || wish->second.link->id != credit.link()) return;
  OutLink& link = *wish->second.link;
  PeerChannel::Dropped ended;
  if (!link.flow.Confirm(credit.consumed_messages(), credit.consumed_bytes(), ended)) {
    shared_.CountPeerFault(PacketFault::kHead, peer.name(), "it confirms more than it was sent");
    return;
  }
  channels_.SendWaiting(link, ended);
  EndLater(std::move(ended), actions);
  if (link.flow.lossless() && channels_.HasRoom(*link.core)) OutboundCore::TellRoom(link.core, actions);
}

}  // namespace hgros::zmq
