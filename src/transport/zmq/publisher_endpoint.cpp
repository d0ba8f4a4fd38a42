#include "transport/zmq/publisher_endpoint.hpp"

#include <algorithm>
#include <utility>

#include "transport/agreement.hpp"
#include "transport/zmq/curve.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr int kFramesInTurn = 64;  // Frames read before others have their turn.

}  // namespace

PublisherEndpoint::Link::Link(Peer& owner, std::shared_ptr<OutboundCore> channel, const Demand& granted,
                              SessionId subscriber)
    : peer(owner), core(std::move(channel)), id(RandomId()), flow(granted), topic(PeerTopic(core->name, subscriber)) {
  topic.append(sizeof(std::uint64_t), '\0');
}

PublisherEndpoint::PublisherEndpoint(Carrier& carrier, const PublishEndpoint& endpoint)
    : carrier_(carrier),
      endpoint_(FullEndpoint(endpoint.endpoint)),
      socket_(carrier.context, ZMQ_XPUB),
      last_handshake_(RandomId()) {
  if (endpoint.channels) allowed_.emplace(endpoint.channels->begin(), endpoint.channels->end());
  // Credits bound what is under way; ZeroMQ's own limits would drop the newest silently.
  socket_.Set(ZMQ_SNDHWM, 0);
  socket_.Set(ZMQ_RCVHWM, 0);
  // Every subscription is told, also one that another connection has already: after a reconnect the old connection
  // may end after the new one has begun. Unsubscriptions are told when the last is gone.
  socket_.Set(ZMQ_XPUB_VERBOSE, 1);
  socket_.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(kMaxUpstreamBytes));
  socket_.Set(ZMQ_TCP_KEEPALIVE, 1);
  socket_.Set(ZMQ_TCP_MAXRT, static_cast<int>(2 * carrier.options.peer_timeout.count()));
  if (carrier.options.security) SecureServer(socket_, *carrier.options.security);
  BindOrThrow(socket_, endpoint_);
  bound_ = socket_.LastEndpoint();
  fd_ = socket_.Fd();
}

PublisherEndpoint::~PublisherEndpoint() = default;

bool PublisherEndpoint::Allowed(const std::string& channel) const {
  return !allowed_ || allowed_->contains(ListedAs(channel));
}

void PublisherEndpoint::Offer(const std::shared_ptr<OutboundCore>& core) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
    Channel& channel = channels_[core->name];
    channel = Channel{.core = core, .allowed = Allowed(core->name), .plain = false, .links = {}};
    if (channel.allowed) OpenChannel(channel, actions);
  }
  carrier_.Post(std::move(actions));
}

void PublisherEndpoint::Withdraw(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  const auto found = channels_.find(core->name);
  if (found == channels_.end() || found->second.core != core) return;
  CloseChannel(found->second, actions);
  channels_.erase(found);
}

void PublisherEndpoint::SetChannels(const ChannelList& list) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
    allowed_.reset();
    if (list) allowed_.emplace(list->begin(), list->end());
    for (auto& [name, channel] : channels_) {
      const bool allowed = Allowed(name);
      if (allowed == channel.allowed) continue;
      channel.allowed = allowed;
      if (allowed) {
        OpenChannel(channel, actions);
      } else {
        CloseChannel(channel, actions);
      }
    }
  }
  carrier_.Post(std::move(actions));
}

void PublisherEndpoint::TellOffer(const Channel& channel, bool came) {
  auto said = ControlFrom(carrier_.self.info.id);
  auto& offers = *said.mutable_offers();
  if (came) {
    WriteType(channel.core->name, channel.core->type, *offers.add_came());
  } else {
    offers.add_gone(channel.core->name);
  }
  for (const auto& [id, peer] : peers_) {
    if (!peer->cut && peer->facts.wire_minor >= kOffersSinceMinor) Say(*peer, said);
  }
  for (auto& [id, greeting] : greetings_) {
    const auto peer = peers_.find(id);
    if (peer != peers_.end() && !peer->second->cut) continue;
    greeting.stale = true;
    if (!came) greeting.gone.insert(channel.core->name);
  }
}

// To one who has just said Hello: what it was told in the Welcome may be the past.
void PublisherEndpoint::TellAllOffers(const Peer& peer, Greeting& greeting) {
  if (!std::exchange(greeting.stale, false) || peer.facts.wire_minor < kOffersSinceMinor) return;
  auto said = ControlFrom(carrier_.self.info.id);
  auto& offers = *said.mutable_offers();
  for (const std::string& channel : std::exchange(greeting.gone, {})) offers.add_gone(channel);
  for (const auto& [name, channel] : channels_) {
    if (channel.allowed) WriteType(name, channel.core->type, *offers.add_came());
  }
  Say(peer, said);
}

void PublisherEndpoint::AddWishes(std::vector<SessionChannels>& known) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [id, peer] : peers_) {
    SessionChannels& session = known.emplace_back(SessionChannels{peer->facts.info, {}});
    for (const auto& [channel, wish] : peer->wishes) {
      auto use = ReadUse(wish.asked.wanted());
      if (!use) continue;
      use->subscribes = true;
      use->lossless = wish.asked.lossless();
      session.channels.push_back(std::move(*use));
    }
  }
}

void PublisherEndpoint::OpenChannel(Channel& channel, Actions& actions) {
  TellOffer(channel, true);
  UpdatePlain(channel, actions);
  for (auto& [id, peer] : peers_) {
    const auto wish = peer->wishes.find(channel.core->name);
    if (wish != peer->wishes.end() && !wish->second.link) Activate(*peer, wish->second, actions);
  }
}

void PublisherEndpoint::CloseChannel(Channel& channel, Actions& actions) {
  TellOffer(channel, false);
  if (channel.plain) {
    channel.plain = false;
    OutboundCore::CountSubscriber(channel.core, {}, -1, actions);
  }
  while (!channel.links.empty()) {
    Peer& peer = channel.links.back()->peer;
    auto said = ControlFrom(carrier_.self.info.id);
    said.mutable_withdrawn()->set_channel(channel.core->name);
    Say(peer, said);
    RemoveLink(peer.wishes.at(channel.core->name), true, actions);
  }
}

void PublisherEndpoint::UpdatePlain(Channel& channel, Actions& actions) {
  const bool plain = channel.allowed && plain_channels_.contains(channel.core->name);
  if (plain == channel.plain) return;
  channel.plain = plain;
  OutboundCore::CountSubscriber(channel.core, {}, plain ? 1 : -1, actions);
}

bool PublisherEndpoint::HasRoomLocked(const OutboundCore& core) const {
  const auto found = channels_.find(core.name);
  if (found == channels_.end()) return true;
  return std::ranges::all_of(found->second.links,
                             [](const Link* link) { return !link->flow.lossless() || link->flow.HasRoom(); });
}

void PublisherEndpoint::ReserveLocked(const OutboundCore& core) {
  const auto found = channels_.find(core.name);
  if (found == channels_.end()) return;
  for (Link* link : found->second.links) {
    if (link->flow.lossless()) link->flow.Reserve();
  }
}

void PublisherEndpoint::Cancel(const std::shared_ptr<OutboundCore>& core) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = channels_.find(core->name);
    if (found == channels_.end()) return;
    for (Link* link : found->second.links) link->flow.CancelReservation();
    if (HasRoomLocked(*core)) OutboundCore::TellRoom(core, actions);
  }
  carrier_.Post(std::move(actions));
}

void PublisherEndpoint::Commit(const std::shared_ptr<OutboundCore>& core,
                               const std::shared_ptr<const WireMessage>& message, PeerChannel::Dropped& dropped) {
  Actions actions;
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  const auto found = channels_.find(core->name);
  if (found == channels_.end() || found->second.core != core) return;
  bool skipped = false;
  for (Link* link : found->second.links) {
    skipped = !link->flow.Push({message, message->id(), message->bytes()}) || skipped;
    Drain(*link, dropped);
  }
  // Its reservation is free again, and somebody may have been refused meanwhile.
  if (skipped && HasRoomLocked(*core)) {
    OutboundCore::TellRoom(core, actions);
    carrier_.Post(std::move(actions));
  }
  if (!found->second.plain) return;
  if (plain_bytes_->load(std::memory_order_relaxed) >= carrier_.options.plain_queue_bytes) {
    core->dropped.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  message->SendCounted(socket_, core->plain_topic, plain_bytes_);
  core->sent.fetch_add(1, std::memory_order_relaxed);
}

void PublisherEndpoint::Discard(PeerChannel::Dropped&& dropped, Actions& actions) {
  if (!dropped.empty()) actions.emplace_back([ended = std::move(dropped)] {});
}

void PublisherEndpoint::Drain(Link& link, PeerChannel::Dropped& dropped) {
  while (auto message = link.flow.Pop()) {
    WriteLinkNumber(link.topic, link.flow.sent());
    static_cast<const WireMessage&>(*message->packed).SendTo(socket_, link.topic);
    link.core->sent.fetch_add(1, std::memory_order_relaxed);
    dropped.push_back(std::move(*message));  // It may end with it.
  }
  const std::uint64_t others = link.peer.waiting_bytes - link.counted_bytes;
  const std::uint64_t limit = carrier_.options.peer_queue_bytes;
  if (const auto count = link.flow.Trim(limit > others ? limit - others : 0, dropped); count > 0) {
    link.core->dropped.fetch_add(count, std::memory_order_relaxed);
  }
  CountWaiting(link);
}

void PublisherEndpoint::CountWaiting(Link& link) {
  const std::uint64_t now = link.flow.waiting_bytes();
  link.peer.waiting_bytes += now - link.counted_bytes;  // Wraps around to the right sum.
  link.core->queued_bytes.fetch_add(now - link.counted_bytes, std::memory_order_relaxed);
  link.counted_bytes = now;
}

void PublisherEndpoint::RemoveLink(Wish& wish, bool died, Actions& actions) {
  if (!wish.link) return;
  const std::shared_ptr<Link> link = std::move(wish.link);
  if (const auto channel = channels_.find(link->core->name); channel != channels_.end()) {
    std::erase(channel->second.links, link.get());
  }
  link->peer.waiting_bytes -= link->counted_bytes;
  link->core->queued_bytes.fetch_sub(link->counted_bytes, std::memory_order_relaxed);
  if (link->flow.lossless()) {
    if (died) link->core->missed.fetch_add(link->flow.unfinished(), std::memory_order_relaxed);
    link->core->lossless.fetch_sub(1);
    OutboundCore::TellRoom(link->core, actions);
  }
  OutboundCore::CountSubscriber(link->core, link->peer.facts.info.id, -1, actions);
  actions.emplace_back([link] {});  // Its messages end when no mutex is held: their destructors are the user's code.
}

void PublisherEndpoint::StartLink(const std::shared_ptr<OutboundCore>& core, SessionId session, std::uint64_t link_id) {
  std::vector<PendingMessage> latched;
  const bool open = core->gate.Through([&] {
    for (const auto& message : core->source.Latched(session)) {
      auto wire = std::make_shared<const WireMessage>(message.head, message.data);
      const std::uint64_t bytes = wire->bytes();
      latched.push_back({std::move(wire), message.head.id, bytes});
    }
  });
  if (!open) return;
  const PeerChannel::Dropped held = latched;  // Those that are not needed end after the lock.
  PeerChannel::Dropped dropped;
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  const auto peer = peers_.find(session);
  if (peer == peers_.end()) return;
  const auto wish = peer->second->wishes.find(core->name);
  if (wish == peer->second->wishes.end() || !wish->second.link || wish->second.link->id != link_id) return;
  wish->second.link->flow.Begin(std::move(latched));
  Drain(*wish->second.link, dropped);
}

bool PublisherEndpoint::Serve(Actions& actions) {
  if (!input_.load() || !input_.exchange(false)) return false;
  const std::scoped_lock lock(mutex_);
  Message frame;
  for (int i = 0; i < kFramesInTurn; ++i) {
    if (!socket_.Receive(frame)) return false;
    if (!frame.more()) {
      OnFrame(frame, actions);
      continue;
    }
    // Nobody we know sends several frames this way.
    while (frame.more() && socket_.Receive(frame)) {
    }
    carrier_.CountFault(PacketFault::kLength, bound_, "a control message of several frames");
  }
  input_ = true;
  return true;
}

bool PublisherEndpoint::AllSent() const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::all_of(peers_, [](const auto& entry) { return entry.second->waiting_bytes == 0; });
}

void PublisherEndpoint::Close(int linger_ms, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  auto bye = ControlFrom(carrier_.self.info.id);
  bye.mutable_bye();
  while (!peers_.empty()) {
    Say(*peers_.begin()->second, bye);
    DropPeer(peers_.begin()->first, "the endpoint was closed", actions);
  }
  if (socket_.closed()) return;
  socket_.Set(ZMQ_LINGER, linger_ms);
  Unbind(carrier_.context, socket_, bound_);
  socket_.Close(linger_ms);
}

}  // namespace hgros::zmq
