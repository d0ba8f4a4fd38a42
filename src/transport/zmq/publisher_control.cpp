// What subscribers say to a publish endpoint, and what it answers.
#include <algorithm>
#include <string>
#include <utility>

#include "hgros/base/names.hpp"
#include "transport/zmq/endpoint.hpp"
#include "transport/zmq/publisher_endpoint.hpp"

namespace hgros::zmq {
namespace {

// What strangers may make us remember.
constexpr std::size_t kMaxPeers = 1024;
constexpr std::size_t kMaxGreetings = 4096;
constexpr std::size_t kMaxWishes = 4096;
constexpr std::size_t kMaxPlainChannels = 16384;
constexpr auto kGreetAgainAfter = std::chrono::milliseconds(200);

Demand DemandOf(const wire::Subscribe& asked, const ZmqOptions& options) {
  return PeerChannel::Granted({.lossless = asked.lossless(),
                               .queue_depth = asked.queue_depth(),
                               .credit_messages = asked.credit_messages(),
                               .credit_bytes = asked.credit_bytes()},
                              options.max_credit_bytes);
}

std::string Who(const PeerInfo& peer) { return peer.process + " (session " + peer.id.ToString() + ")"; }

}  // namespace

void PublisherEndpoint::Say(const std::string& topic, const wire::Control& control) {
  socket_.Send(topic, true);
  socket_.Send(control.SerializeAsString(), false);
}

void PublisherEndpoint::OnFrame(Message& frame, Actions& actions) {
  const std::string_view text = AsText(frame.bytes());
  if (text.empty()) {
    carrier_.CountFault(PacketFault::kTruncated, bound_, "an empty control message");
  } else if (text[0] == '\0' || text[0] == '\1') {
    OnTopic(text[0] == '\1', text.substr(1), frame, actions);
  } else if (text[0] == kControlByte) {
    OnUpstream(frame.bytes().subspan(1), actions);
  } else {
    carrier_.CountFault(PacketFault::kHead, bound_, "not a control message");
  }
}

void PublisherEndpoint::OnTopic(bool subscribed, std::string_view text, Message& frame, Actions& actions) {
  if (const auto session = ParseControlTopic(text)) {
    if (subscribed) {
      Greet(*session, true);
      return;
    }
    greetings_.erase(*session);
    const auto found = peers_.find(*session);
    if (found == peers_.end()) return;
    // Whoever may not lose anything gets some time to come back.
    Peer& peer = *found->second;
    const bool waits = std::ranges::any_of(
        peer.wishes, [](const auto& entry) { return entry.second.link && entry.second.link->flow.lossless(); });
    if (waits) {
      peer.cut = true;
      PauseLinks(peer);
    } else {
      DropPeer(*session, "the connection was closed", actions);
    }
    return;
  }
  const auto topic = ParseTopic(AsBytes(text));
  if (!topic) {
    if (subscribed) Refuse(text, frame);
    return;
  }
  if (topic->session.value != 0) return;  // A session's data: it says by itself which it wants.
  if (!subscribed) {
    plain_channels_.erase(std::string(topic->channel));
  } else if (plain_channels_.size() < kMaxPlainChannels) {
    plain_channels_.emplace(topic->channel);
  } else {
    carrier_.log.WriteLimited(LogLevel::kWarning, "zmq plain topics " + bound_,
                              "More than " + std::to_string(kMaxPlainChannels) + " plain subscriptions at " + bound_ +
                                  "; further ones are ignored.");
  }
  const auto channel = channels_.find(std::string(topic->channel));
  if (channel != channels_.end()) UpdatePlain(channel->second, actions);
}

// ZeroMQ matches it as a prefix: it would be sent what is meant for sessions, and nobody would know how much of that
// waits for it. ZeroMQ 4.3 has no sound way of giving a connection another filter than the one it asks for.
void PublisherEndpoint::Refuse(std::string_view filter, Message& frame) {
  HangUp(frame, bound_);
  carrier_.log.WriteLimited(LogLevel::kWarning, "zmq filter " + bound_,
                            "A plain subscriber at " + bound_ + " asks for all that begins with \"" +
                                Readable(std::string(filter.substr(0, kMaxTextBytes))) +
                                "\", which is no topic as a whole: its connection is closed. Let it subscribe to the "
                                "name of a channel followed by a zero byte.",
                            std::chrono::hours(1));
}

void PublisherEndpoint::Greet(SessionId session, bool at_once) {
  const auto now = std::chrono::steady_clock::now();
  if (greetings_.size() >= kMaxGreetings) {
    std::erase_if(greetings_, [this](const auto& entry) { return !peers_.contains(entry.first); });
  }
  Greeting& greeting = greetings_[session];
  if (!at_once && now - greeting.when < kGreetAgainAfter) return;
  greeting = {++last_handshake_, now, false, {}};
  if (const auto peer = peers_.find(session); peer != peers_.end()) {
    peer->second->handshake = greeting.handshake;
    PauseLinks(*peer->second);
  }
  auto said = ControlFrom(carrier_.self.info.id);
  auto& welcome = *said.mutable_welcome();
  WriteFacts(carrier_.self, *welcome.mutable_facts());
  welcome.set_handshake(greeting.handshake);
  for (const auto& [name, channel] : channels_) {
    if (channel.allowed) WriteType(name, channel.core->type, *welcome.add_offers());
  }
  Say(ControlTopic(session), said);
}

void PublisherEndpoint::TellWishes(Actions& actions) {
  actions.emplace_back([this] { carrier_.listener.OnChannels(); });
}

void PublisherEndpoint::PauseLinks(Peer& peer) {
  const auto now = std::chrono::steady_clock::now();
  for (auto& [channel, wish] : peer.wishes) {
    if (!wish.link || wish.link->flow.paused()) continue;
    wish.link->flow.Pause();
    wish.link->paused_since = now;
  }
}

void PublisherEndpoint::OnUpstream(Bytes bytes, Actions& actions) {
  const auto control = ParseControl(bytes);
  if (!control) {
    carrier_.CountFault(PacketFault::kHead, bound_, "a control message that does not parse");
    return;
  }
  const SessionId session{control->session()};
  if (control->has_hello()) {
    OnHello(session, control->hello(), actions);
    return;
  }
  const auto found = peers_.find(session);
  if (found == peers_.end()) {
    // One that we gave up, and that does not know.
    if (!control->has_bye()) Greet(session, false);
    return;
  }
  Peer& peer = *found->second;
  peer.last_heard = std::chrono::steady_clock::now();
  switch (control->what_case()) {
    case wire::Control::kSubscribe: OnSubscribe(peer, control->subscribe(), actions); break;
    case wire::Control::kUnsubscribe: OnUnsubscribe(peer, control->unsubscribe(), actions); break;
    case wire::Control::kCredit: OnCredit(peer, control->credit(), actions); break;
    case wire::Control::kHeartbeat: OnHeartbeat(peer, control->heartbeat(), actions); break;
    case wire::Control::kBye: DropPeer(session, "it said goodbye", actions); break;
    default: carrier_.CountFault(PacketFault::kHead, Who(peer.facts.info), "a publisher's control message");
  }
}

void PublisherEndpoint::OnHeartbeat(Peer& peer, const wire::Heartbeat& heartbeat, Actions& actions) {
  const Time now = carrier_.Wall();
  if (auto answer = AnswerTo(heartbeat, now); answer && !peer.cut) {
    auto said = ControlFrom(carrier_.self.info.id);
    *said.mutable_heartbeat() = std::move(*answer);
    Say(peer, said);
  }
  if (const auto exchange = peer.clock.Read(heartbeat, now)) {
    actions.emplace_back(
        [this, info = peer.facts.info, told = *exchange] { carrier_.listener.OnClockExchange(info, told); });
  }
}

void PublisherEndpoint::OnHello(SessionId session, const wire::Hello& hello, Actions& actions) {
  if (hello.handshake() == 0) {
    Greet(session, false);
    return;
  }
  const auto greeting = greetings_.find(session);
  // An answer to an older Welcome: that to the newer one is on its way.
  if (greeting == greetings_.end() || greeting->second.handshake != hello.handshake()) return;
  if (session == carrier_.self.info.id) return;
  if (hello.facts().wire_major() != kWireMajor) {
    carrier_.CountFault(PacketFault::kVersion, bound_,
                        "a subscriber speaks version " + std::to_string(hello.facts().wire_major()));
    return;
  }
  SessionFacts facts = ReadFacts(session, hello.facts());
  auto found = peers_.find(session);
  if (found != peers_.end() && found->second->facts.incarnation != facts.incarnation) {
    DropPeer(session, "it was started anew", actions);
    found = peers_.end();
  }
  if (found == peers_.end()) {
    if (peers_.size() >= kMaxPeers) {
      carrier_.log.WriteLimited(LogLevel::kWarning, "zmq peers " + bound_,
                                "More than " + std::to_string(kMaxPeers) + " sessions subscribe at " + bound_ +
                                    "; further ones are ignored.");
      return;
    }
    found = peers_.emplace(session, std::make_unique<Peer>()).first;
    actions.emplace_back([this, info = facts.info] { carrier_.peers.Came(info); });
    TellWishes(actions);
  }
  Peer& peer = *found->second;
  peer.facts = std::move(facts);
  peer.topic = ControlTopic(session);
  peer.handshake = hello.handshake();
  peer.last_heard = std::chrono::steady_clock::now();
  peer.cut = false;
  TellAllOffers(peer, greeting->second);
}

void PublisherEndpoint::OnSubscribe(Peer& peer, const wire::Subscribe& asked, Actions& actions) {
  if (asked.handshake() != peer.handshake) return;
  const std::string& name = asked.wanted().channel();
  if (!ChannelNameFault(name).empty() || asked.wanted().type_name().size() > kMaxTypeNameBytes ||
      (peer.wishes.size() >= kMaxWishes && !peer.wishes.contains(name))) {
    carrier_.CountFault(PacketFault::kHead, Who(peer.facts.info), "a subscription that cannot be");
    return;
  }
  if (!peer.wishes.contains(name)) TellWishes(actions);
  Wish& wish = peer.wishes[name];
  wish.asked = asked;
  const Demand granted = DemandOf(asked, carrier_.options);
  PeerChannel::Dropped dropped;
  std::string descriptor_set;
  if (Link* link = wish.link.get()) {
    if (!asked.change_only()) {
      std::optional<std::uint64_t> lost;
      if (asked.link() == link->id) {
        lost = link->flow.Resume(asked.received_messages(), asked.received_bytes());
      } else if (asked.link() == 0 && granted.lossless && link->flow.lossless()) {
        // The connection ended before our Subscribed was read: what was promised on the link since is still owed.
        if (auto schema = SchemaFor(asked.wanted(), link->core->type)) {
          lost = link->flow.Resume(0, 0);
          descriptor_set = std::move(*schema);
        }
      }
      if (!lost) {
        RemoveLink(wish, true, actions);
        Activate(peer, wish, actions);
        return;
      }
      link->core->dropped.fetch_add(*lost, std::memory_order_relaxed);
    }
    if (link->flow.lossless() != granted.lossless)
      link->core->lossless.fetch_add(granted.lossless ? 1 : std::size_t(-1));
    link->core->dropped.fetch_add(link->flow.SetDemand(granted, dropped), std::memory_order_relaxed);
    SendSubscribed(peer, *link, descriptor_set);
    Drain(*link, dropped);
    Discard(std::move(dropped), actions);
    OutboundCore::TellRoom(link->core, actions);
    return;
  }
  Activate(peer, wish, actions);
}

void PublisherEndpoint::Activate(Peer& peer, Wish& wish, Actions& actions) {
  const auto& wanted = wish.asked.wanted();
  const auto found = channels_.find(wanted.channel());
  if (found == channels_.end() || !found->second.allowed) {
    // The subscriber may have asked because of a Welcome that said otherwise.
    auto said = ControlFrom(carrier_.self.info.id);
    said.mutable_withdrawn()->set_channel(wanted.channel());
    Say(peer, said);
    return;
  }
  const auto& core = found->second.core;
  const auto descriptor_set = SchemaFor(wanted, core->type);
  if (!descriptor_set) {
    const std::string what = DescribeMismatch(wanted, core->type);
    auto said = ControlFrom(carrier_.self.info.id);
    WriteType(core->name, core->type, *said.mutable_refused()->mutable_offered());
    said.mutable_refused()->set_reason(what);
    Say(peer, said);
    TellMismatch(peer, core->name, what, actions);
    return;
  }
  wish.link = std::make_unique<Link>(peer, core, DemandOf(wish.asked, carrier_.options), peer.facts.info.id);
  found->second.links.push_back(wish.link.get());
  if (wish.link->flow.lossless()) core->lossless.fetch_add(1);
  OutboundCore::CountSubscriber(core, peer.facts.info.id, 1, actions);
  SendSubscribed(peer, *wish.link, *descriptor_set);
  if (peer.cut) {
    wish.link->flow.Pause();
    wish.link->paused_since = std::chrono::steady_clock::now();
  }
  actions.emplace_back(
      [this, core, session = peer.facts.info.id, id = wish.link->id] { StartLink(core, session, id); });
}

void PublisherEndpoint::SendSubscribed(Peer& peer, const Link& link, const std::string& descriptor_set) {
  auto said = ControlFrom(carrier_.self.info.id);
  auto& subscribed = *said.mutable_subscribed();
  WriteType(link.core->name, link.core->type, *subscribed.mutable_offered());
  subscribed.set_link(link.id);
  subscribed.set_next_message(link.flow.sent() + 1);
  subscribed.set_credit_messages(link.flow.demand().credit_messages);
  subscribed.set_credit_bytes(link.flow.demand().credit_bytes);
  subscribed.set_descriptor_set(descriptor_set);
  Say(peer, said);
}

void PublisherEndpoint::OnUnsubscribe(Peer& peer, const wire::Unsubscribe& unsubscribe, Actions& actions) {
  const auto wish = peer.wishes.find(unsubscribe.channel());
  if (wish == peer.wishes.end()) return;
  const bool linked = wish->second.link != nullptr;
  RemoveLink(wish->second, false, actions);
  if (linked && !unsubscribe.mismatch().empty())
    TellMismatch(peer, wish->first, Readable(unsubscribe.mismatch()), actions);
  peer.wishes.erase(wish);
  TellWishes(actions);
}

void PublisherEndpoint::OnCredit(Peer& peer, const wire::Credit& credit, Actions& actions) {
  const auto wish = peer.wishes.find(credit.channel());
  if (wish == peer.wishes.end() || !wish->second.link || wish->second.link->id != credit.link()) return;
  Link& link = *wish->second.link;
  PeerChannel::Dropped dropped;
  if (!link.flow.Confirm(credit.consumed_messages(), credit.consumed_bytes(), dropped)) {
    carrier_.CountFault(PacketFault::kHead, Who(peer.facts.info), "it confirms more than it was sent");
    return;
  }
  Drain(link, dropped);
  Discard(std::move(dropped), actions);
  if (link.flow.lossless() && HasRoomLocked(*link.core)) OutboundCore::TellRoom(link.core, actions);
}

void PublisherEndpoint::TellMismatch(Peer& peer, const std::string& channel, const std::string& what,
                                     Actions& actions) {
  if (peer.told_mismatch.size() >= kMaxWishes || !peer.told_mismatch.insert(channel).second) return;
  actions.emplace_back(
      [this, info = peer.facts.info, channel, what] { carrier_.listener.OnTypeMismatch(channel, info, what); });
}

void PublisherEndpoint::DropPeer(SessionId session, std::string_view reason, Actions& actions) {
  const auto found = peers_.find(session);
  if (found == peers_.end()) return;
  for (auto& [channel, wish] : found->second->wishes) RemoveLink(wish, true, actions);
  actions.emplace_back(
      [this, info = found->second->facts.info, said = std::string(reason)] { carrier_.peers.Gone(info, said); });
  peers_.erase(found);
  TellWishes(actions);
}

void PublisherEndpoint::Tick(SteadyTime now, Actions& actions) {
  const auto timeout = carrier_.options.peer_timeout;
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  auto heartbeat = ControlFrom(carrier_.self.info.id);
  std::vector<SessionId> silent;
  for (auto& [session, peer] : peers_) {
    if (now - peer->last_heard > timeout) {
      silent.push_back(session);
      continue;
    }
    if (!peer->cut) {
      peer->clock.Ask(*heartbeat.mutable_heartbeat(), carrier_.Wall());
      Say(*peer, heartbeat);
    }
    for (auto& [channel, wish] : peer->wishes) {
      // It came back without asking for this channel again.
      const bool stale = wish.link && wish.link->flow.paused() && now - wish.link->paused_since > timeout;
      if (stale) RemoveLink(wish, true, actions);
    }
  }
  for (const auto session : silent) {
    DropPeer(session, "it was silent for " + std::to_string(timeout.count()) + " ms", actions);
  }
}

void PublisherEndpoint::Forgive(SteadyTime now) {
  const std::scoped_lock lock(mutex_);
  for (auto& [session, peer] : peers_) peer->last_heard = now;
}

}  // namespace hgros::zmq
