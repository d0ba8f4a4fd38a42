#include "transport/zmq/publish/subscriber_peers.hpp"

#include <algorithm>
#include <utility>

#include "transport/agreement.hpp"
#include "transport/zmq/connection.hpp"
#include "transport/zmq/control.hpp"

namespace hgros::zmq {
namespace {

// A limit against strangers, who could fill the memory.
constexpr std::size_t kMaxPeers = 1024;
constexpr std::size_t kMaxGreetings = 4096;
constexpr std::size_t kMaxReportedMismatches = 4096;
constexpr std::string_view kOfTheLibrary = "hgros/";
constexpr auto kGreetAgainAfter = std::chrono::milliseconds(200);

}  // namespace

SubscriberPeers::SubscriberPeers(SharedState& shared, Socket& socket, PublishedChannels& channels,
                                 ConnectionWatch& watch, const std::string& endpoint)
    : shared_(shared),
      socket_(socket),
      channels_(channels),
      watch_(watch),
      endpoint_(endpoint),
      last_handshake_(RandomId()) {}

void SubscriberPeers::Send(const std::string& topic, const wire::Control& control, int connection) {
  const std::string text = control.SerializeAsString();
  socket_.Send(topic, true);
  socket_.Send(text, false);
  watch_.CountSent(connection, topic.size() + text.size());
}

SubscriberPeer* SubscriberPeers::Find(SessionId session) {
  const auto found = peers_.find(session);
  return found == peers_.end() ? nullptr : found->second.get();
}

std::vector<SubscriberPeer*> SubscriberPeers::FindWaiting(const std::string& channel) {
  std::vector<SubscriberPeer*> waiting;
  for (auto& [id, peer] : peers_) {
    const auto wish = peer->wishes.find(channel);
    if (wish != peer->wishes.end() && !wish->second.link) waiting.push_back(peer.get());
  }
  return waiting;
}

void SubscriberPeers::Greet(SessionId session, int connection, bool at_once) {
  const auto greeted = greetings_.find(session);
  if (!at_once && greeted != greetings_.end() &&
      std::chrono::steady_clock::now() - greeted->second.when < kGreetAgainAfter) {
    return;
  }
  SubscriberPeer* peer = Find(session);
  if (peer != nullptr && (peer->cut || watch_.MaySpeakFor(connection, session, peer->proof))) {
    BeginAgain(*peer, connection);
  } else {
    SendWelcome(session, connection);
  }
}

void SubscriberPeers::BeginAgain(SubscriberPeer& peer, int connection) {
  PauseLinks(peer);
  SendWelcome(peer.facts.info.id, connection);
  peer.handshake = last_handshake_;
}

void SubscriberPeers::SendWelcome(SessionId session, int connection) {
  if (greetings_.size() >= kMaxGreetings) {
    std::erase_if(greetings_, [this](const auto& entry) { return !peers_.contains(entry.first); });
  }
  Greeting& greeting = greetings_[session];
  greeting = {++last_handshake_, std::chrono::steady_clock::now(), false, {}};
  auto message = ControlFrom(shared_.self.info.id);
  auto& welcome = *message.mutable_welcome();
  WriteFacts(shared_.self, *welcome.mutable_facts());
  welcome.set_handshake(greeting.handshake);
  channels_.AddOffers(*welcome.mutable_offers());
  Send(ControlTopic(session), message, connection);
}

void SubscriberPeers::OnHello(SessionId session, const wire::Hello& hello, int connection, Actions& actions) {
  if (hello.handshake() == 0) {
    Greet(session, connection, false);
    return;
  }
  const auto greeting = greetings_.find(session);
  // Ignores an answer to an older Welcome: the answer to the newer one is on its way.
  if (greeting == greetings_.end() || greeting->second.handshake != hello.handshake()) return;
  if (session == shared_.self.info.id) return;
  if (hello.facts().wire_major() != kWireMajor) {
    shared_.CountFault(PacketFault::kVersion, endpoint_,
                       "a subscriber speaks version " + std::to_string(hello.facts().wire_major()));
    return;
  }
  SessionFacts facts = ReadFacts(session, hello.facts());
  SubscriberPeer* peer = Find(session);
  if (peer != nullptr && !peer->cut && peer->proof != hello.proof()) {
    shared_.CountFault(PacketFault::kHead, endpoint_,
                       "a Hello in the name of " + peer->name() + ", which is another program");
    return;
  }
  if (peer != nullptr && peer->facts.incarnation != facts.incarnation) {
    Drop(session, "it was restarted", actions);
    peer = nullptr;
  }
  if (peer != nullptr && peer->handshake != hello.handshake() &&
      !watch_.MaySpeakFor(connection, session, peer->proof)) {
    // It has a new connection. The Welcome paused nothing, because a stranger might have asked for it.
    watch_.NoteProof(connection, hello.proof());
    BeginAgain(*peer, connection);
    return;
  }
  if (peer == nullptr) {
    if (peers_.size() >= kMaxPeers) {
      shared_.log.WriteLimited(LogLevel::kWarning, "zmq peers " + endpoint_,
                               "More than " + std::to_string(kMaxPeers) + " sessions subscribe at " + endpoint_ +
                                   "; further ones are ignored.");
      return;
    }
    peer = peers_.emplace(session, std::make_unique<SubscriberPeer>()).first->second.get();
    actions.emplace_back([this, info = facts.info] { shared_.peers.Came(info); });
    shared_.AddChannelsChanged(actions);
  }
  peer->facts = std::move(facts);
  peer->topic = ControlTopic(session);
  peer->handshake = hello.handshake();
  peer->proof = hello.proof();
  peer->connection = connection;
  peer->last_heard = std::chrono::steady_clock::now();
  peer->cut = peer->replaced = false;
  watch_.NoteProof(connection, hello.proof());
  RepeatOffers(*peer, greeting->second);
}

// For a peer that has just sent Hello: the Welcome that it answers may be out of date.
void SubscriberPeers::RepeatOffers(const SubscriberPeer& peer, Greeting& greeting) {
  if (!std::exchange(greeting.stale, false) || peer.facts.wire_minor < kOffersSinceMinor) return;
  auto message = ControlFrom(shared_.self.info.id);
  auto& offers = *message.mutable_offers();
  for (const std::string& channel : std::exchange(greeting.gone, {})) offers.add_gone(channel);
  channels_.AddOffers(*offers.mutable_came());
  Send(peer, message);
}

void SubscriberPeers::AnnounceOffer(const OutboundCore& core, bool came) {
  auto message = ControlFrom(shared_.self.info.id);
  auto& offers = *message.mutable_offers();
  if (came) {
    WriteType(core.name, core.type, *offers.add_came());
  } else {
    offers.add_gone(core.name);
  }
  for (const auto& [id, peer] : peers_) {
    if (!peer->cut && peer->facts.wire_minor >= kOffersSinceMinor) Send(*peer, message);
  }
  for (auto& [id, greeting] : greetings_) {
    const SubscriberPeer* peer = Find(id);
    if (peer != nullptr && !peer->cut) continue;
    greeting.stale = true;
    if (!came) greeting.gone.insert(core.name);
  }
}

void SubscriberPeers::OnHeartbeat(SubscriberPeer& peer, const wire::Heartbeat& heartbeat, Actions& actions) {
  const Time now = shared_.Wall();
  if (auto answer = AnswerTo(heartbeat, now); answer && !peer.cut) {
    auto message = ControlFrom(shared_.self.info.id);
    *message.mutable_heartbeat() = std::move(*answer);
    Send(peer, message);
  }
  if (peer.last_question != 0 && heartbeat.answer_to_ns() == peer.last_question) peer.received_all = true;
  if (const auto exchange = peer.clock.Read(heartbeat, now)) {
    actions.emplace_back(
        [this, info = peer.facts.info, told = *exchange] { shared_.listener.OnClockExchange(info, told); });
  }
}

void SubscriberPeers::OnDisconnected(SessionId session, Actions& actions) {
  greetings_.erase(session);
  SubscriberPeer* peer = Find(session);
  if (peer == nullptr) return;
  // A lossless subscriber gets some time to come back.
  const bool waits = std::ranges::any_of(
      peer->wishes, [](const auto& entry) { return entry.second.link && entry.second.link->flow.lossless(); });
  if (waits && !peer->replaced) {
    peer->cut = true;
    PauseLinks(*peer);
  } else {
    Drop(session, "the connection was closed", actions);
  }
}

void SubscriberPeers::OnReplaced(SessionId session, Actions& actions) {
  SubscriberPeer* peer = Find(session);
  if (peer == nullptr) return;
  peer->replaced = true;
  if (peer->cut) Drop(session, "another session took its place", actions);
}

void SubscriberPeers::PauseLinks(SubscriberPeer& peer) {
  peer.last_question = 0;
  peer.received_all = false;
  const auto now = std::chrono::steady_clock::now();
  for (auto& [channel, wish] : peer.wishes) {
    if (wish.link) wish.link->Pause(now);
  }
}

void SubscriberPeers::Drop(SessionId session, std::string_view reason, Actions& actions, LinkEnd links) {
  const auto found = peers_.find(session);
  if (found == peers_.end()) return;
  watch_.ForgetWishes(session);
  for (auto& [channel, wish] : found->second->wishes) channels_.RemoveLink(*found->second, wish, links, actions);
  actions.emplace_back(
      [this, info = found->second->facts.info, text = std::string(reason)] { shared_.peers.Gone(info, text); });
  peers_.erase(found);
  shared_.AddChannelsChanged(actions);
}

void SubscriberPeers::ReportMismatch(SubscriberPeer& peer, const std::string& channel, const std::string& what,
                                     Actions& actions) {
  auto& reported = peer.reported_mismatches;
  if (reported.size() >= kMaxReportedMismatches || !reported.insert(channel).second) return;
  actions.emplace_back(
      [this, info = peer.facts.info, channel, what] { shared_.listener.OnTypeMismatch(channel, info, what); });
}

void SubscriberPeers::Tick(SteadyTime now, Actions& actions) {
  const auto timeout = shared_.options.peer_timeout;
  auto heartbeat = ControlFrom(shared_.self.info.id);
  const auto timeout_if_replaced = std::min(timeout, 2 * shared_.options.heartbeat);
  std::vector<SessionId> silent;
  for (auto& [session, peer] : peers_) {
    if (!peer->cut && !peer->replaced) shared_.silence.Note(peer->facts.info, peer->last_heard);
    if (now - peer->last_heard > (peer->replaced ? timeout_if_replaced : timeout)) {
      silent.push_back(session);
      continue;
    }
    // At the end no more are sent: that its kernel has got them would look like progress.
    if (!peer->cut && peer->last_question == 0) {
      peer->clock.Ask(*heartbeat.mutable_heartbeat(), shared_.Wall());
      Send(*peer, heartbeat);
    }
    for (auto& [channel, wish] : peer->wishes) {
      if (!wish.link) continue;
      const OutboundCore& core = *wish.link->core;
      if (wish.link->flow.HoldsUp(core.refused, now)) core.SayHeldUp(shared_.log, peer->name());
      // It came back without asking for this channel again.
      if (wish.link->IsPausedSince(now - timeout)) channels_.RemoveLink(*peer, wish, LinkEnd::kLost, actions);
    }
  }
  for (const auto session : silent) {
    const auto patience = peers_.at(session)->replaced ? timeout_if_replaced : timeout;
    Drop(session, "it was silent for " + std::to_string(patience.count()) + " ms", actions);
  }
}

void SubscriberPeers::ForgiveSilence(SteadyTime now) {
  for (auto& [session, peer] : peers_) peer->last_heard = now;
}

void SubscriberPeers::LookAtArriving(Arriving& arriving) {
  for (auto& [session, peer] : peers_) {
    std::uint64_t unconfirmed = 0;
    std::uint64_t confirmed = 0;
    for (const auto& [channel, wish] : peer->wishes) {
      if (!wish.link) continue;
      unconfirmed += wish.link->flow.unconfirmed();
      confirmed += wish.link->flow.confirmed();
    }
    const bool all_sent = peer->waiting_bytes == 0;
    if (all_sent && (unconfirmed == 0 || peer->received_all || peer->cut)) continue;
    arriving.any = true;
    arriving.progress += confirmed + BytesAcknowledged(peer->connection).value_or(0);
    if (!all_sent || peer->cut || peer->last_question != 0) continue;
    const Time now = shared_.Wall();
    auto question = ControlFrom(shared_.self.info.id);
    peer->clock.Ask(*question.mutable_heartbeat(), now);
    peer->last_question = now.nanoseconds;
    peer->asked = true;
    Send(*peer, question);
  }
}

void SubscriberPeers::AddUnconfirmed(SharedState::Unconfirmed& unconfirmed) const {
  for (const auto& [session, peer] : peers_) {
    if (peer->received_all) continue;
    if (peer->waiting_bytes > 0 && !peer->asked) continue;  // That is told elsewhere.
    for (const auto& [channel, wish] : peer->wishes) {
      if (!wish.link || !wish.link->flow.lossless() || channel.starts_with(kOfTheLibrary)) continue;
      const std::size_t messages = wish.link->flow.unfinished();
      unconfirmed.messages += messages;
      if (messages > 0) unconfirmed.channel = channel;
    }
  }
}

void SubscriberPeers::AddWishes(std::vector<SessionChannels>& known) const {
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

void SubscriberPeers::DropAll(std::string_view reason, Actions& actions) {
  auto bye = ControlFrom(shared_.self.info.id);
  bye.mutable_bye();
  // Those that have got a Welcome, but whose Hello has not come yet, know this session, too.
  for (const auto& [session, greeting] : greetings_) {
    if (!peers_.contains(session)) Send(ControlTopic(session), bye, -1);
  }
  while (!peers_.empty()) {
    Send(*peers_.begin()->second, bye);
    Drop(peers_.begin()->first, reason, actions, LinkEnd::kWithdrawn);
  }
}

}  // namespace hgros::zmq
