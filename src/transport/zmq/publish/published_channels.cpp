#include "transport/zmq/publish/published_channels.hpp"

#include <algorithm>
#include <utility>

#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kMaxPlainTopics = 16384;  // A limit against strangers, who could fill the memory.

}  // namespace

PublishedChannels::PublishedChannels(SharedState& shared, Socket& socket, const ChannelList& allowed)
    : shared_(shared), socket_(socket) {
  if (allowed) allowed_.emplace(allowed->begin(), allowed->end());
}

bool PublishedChannels::IsAllowed(const std::string& channel) const {
  return !allowed_ || allowed_->contains(ListedAs(channel));
}

PublishedChannels::Channel& PublishedChannels::Add(const std::shared_ptr<OutboundCore>& core) {
  Channel& channel = channels_[core->name];
  channel = Channel{.core = core, .allowed = IsAllowed(core->name), .plain = false, .links = {}};
  return channel;
}

PublishedChannels::Channel* PublishedChannels::Find(const std::string& name) {
  const auto found = channels_.find(name);
  return found == channels_.end() ? nullptr : &found->second;
}

PublishedChannels::Channel* PublishedChannels::Find(const std::shared_ptr<OutboundCore>& core) {
  const auto found = channels_.find(core->name);
  return found == channels_.end() || found->second.core != core ? nullptr : &found->second;
}

std::vector<PublishedChannels::Channel*> PublishedChannels::SetAllowed(const ChannelList& allowed) {
  allowed_.reset();
  if (allowed) allowed_.emplace(allowed->begin(), allowed->end());
  std::vector<Channel*> changed;
  for (auto& [name, channel] : channels_) {
    const bool now = IsAllowed(name);
    if (std::exchange(channel.allowed, now) != now) changed.push_back(&channel);
  }
  return changed;
}

void PublishedChannels::AddOffers(google::protobuf::RepeatedPtrField<wire::ChannelType>& offers) const {
  std::size_t bytes = 0;
  for (const auto& [name, channel] : channels_) {
    if (!channel.allowed) continue;
    WriteType(name, channel.core->type, *offers.Add());
    bytes += offers.rbegin()->ByteSizeLong();
    // Only lists of channels show the offers: channels are asked for by name.
    if (bytes > kMaxControlBytes / 2) return;
  }
}

bool PublishedChannels::HasRoom(const OutboundCore& core) const {
  const auto found = channels_.find(core.name);
  if (found == channels_.end()) return true;
  return std::ranges::all_of(found->second.links,
                             [](const OutLink* link) { return !link->flow.lossless() || link->flow.HasRoom(); });
}

std::size_t PublishedChannels::Unfinished(const OutboundCore& core) const {
  const auto found = channels_.find(core.name);
  if (found == channels_.end()) return 0;
  std::size_t unfinished = 0;
  for (const OutLink* link : found->second.links) {
    if (link->flow.lossless()) unfinished += link->flow.unfinished();
  }
  return unfinished;
}

void PublishedChannels::Reserve(const OutboundCore& core) {
  const auto found = channels_.find(core.name);
  if (found == channels_.end()) return;
  for (OutLink* link : found->second.links) {
    if (link->flow.lossless()) link->flow.Reserve();
  }
}

void PublishedChannels::CancelReservation(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  const auto found = channels_.find(core->name);
  if (found == channels_.end()) return;
  for (OutLink* link : found->second.links) link->flow.CancelReservation();
  if (HasRoom(*core)) OutboundCore::TellRoom(core, actions);
}

void PublishedChannels::Commit(const std::shared_ptr<OutboundCore>& core,
                               const std::shared_ptr<const WireMessage>& message, PeerChannel::Dropped& ended,
                               Actions& actions) {
  const auto found = channels_.find(core->name);
  if (found == channels_.end() || found->second.core != core) return;
  bool skipped = false;
  for (OutLink* link : found->second.links) {
    skipped = !link->flow.Push({message, message->id(), message->bytes()}) || skipped;
    SendWaiting(*link, ended);
  }
  // The reservation of a skipped message is free again, and another thread may have been refused meanwhile.
  if (skipped && HasRoom(*core)) OutboundCore::TellRoom(core, actions);
  if (!found->second.plain) return;
  if (plain_bytes() >= shared_.options.plain_queue_bytes) {
    core->dropped.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  message->SendCounted(socket_, core->plain_topic, plain_bytes_);
  core->sent.fetch_add(1, std::memory_order_relaxed);
}

void PublishedChannels::RemoveLink(const SubscriberPeer& peer, Wish& wish, LinkEnd why, Actions& actions) {
  if (!wish.link) return;
  const std::shared_ptr<OutLink> link = std::move(wish.link);
  if (Channel* channel = Find(link->core->name)) std::erase(channel->links, link.get());
  link->LeaveSums();
  if (why == LinkEnd::kLost && link->flow.lossless()) {
    const std::string who = "Session " + peer.facts.info.name();
    OutboundCore::TellMissed(link->core, shared_.log, link->subscriber, who, link->flow.unfinished(), actions);
  } else if (why != LinkEnd::kUnsubscribed && link->flow.lossless()) {
    link->core->missed.fetch_add(link->flow.unfinished(), std::memory_order_relaxed);
  }
  if (link->flow.lossless()) OutboundCore::TellRoom(link->core, actions);
  if (why == LinkEnd::kUnsubscribed) OutboundCore::TellUnsubscribed(link->core, link->subscriber, actions);
  OutboundCore::CountSubscriber(link->core, link->subscriber, -1, actions);
  actions.emplace_back([link] {});  // Its messages are destroyed when no mutex is held: this runs user code.
}

void PublishedChannels::SetPlainTopic(std::string_view channel, bool subscribed, std::string_view endpoint,
                                      Actions& actions) {
  const std::string name(channel);
  if (!subscribed) {
    plain_topics_.erase(name);
  } else if (plain_topics_.size() < kMaxPlainTopics) {
    plain_topics_.insert(name);
  } else {
    const std::string at(endpoint);
    shared_.log.WriteLimited(LogLevel::kWarning, "zmq plain topics " + at,
                             "More than " + std::to_string(kMaxPlainTopics) + " plain subscriptions at " + at +
                                 "; further ones are ignored.");
  }
  if (Channel* known = Find(name)) UpdatePlain(*known, actions);
}

void PublishedChannels::UpdatePlain(Channel& channel, Actions& actions) {
  const bool plain = channel.allowed && plain_topics_.contains(channel.core->name);
  if (plain == channel.plain) return;
  channel.plain = plain;
  OutboundCore::CountSubscriber(channel.core, {}, plain ? 1 : -1, actions);
}

}  // namespace hgros::zmq
