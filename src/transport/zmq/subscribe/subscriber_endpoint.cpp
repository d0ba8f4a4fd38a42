#include "transport/zmq/subscribe/subscriber_endpoint.hpp"

#include <utility>

#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/socket_use.hpp"

namespace hgros::zmq {
namespace {

constexpr int kMessagesPerTurn = 32;  // Then other endpoints have their turn.
constexpr auto kPauseAfterFault = std::chrono::seconds(5);

}  // namespace

SubscriberEndpoint::SubscriberEndpoint(SharedState& shared, Poller& poller, const SubscribeEndpoint& endpoint,
                                       ClaimsFreed claims_freed, Replaced replaced)
    : shared_(shared),
      poller_(poller),
      on_event_(endpoint.on_event),
      replaced_(std::move(replaced)),
      connection_(shared, endpoint),
      channels_(shared, connection_, publisher_, endpoint.channels, std::move(claims_freed)) {}

SubscriberEndpoint::~SubscriberEndpoint() = default;

void SubscriberEndpoint::Subscribe(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
  channels_.Add(core);
}

void SubscriberEndpoint::Unsubscribe(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
  channels_.Remove(core);
}

void SubscriberEndpoint::UpdateDemand(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
  channels_.UpdateDemand(*core);
}

void SubscriberEndpoint::SetChannels(const ChannelList& list) {
  Actions actions;
  {
    const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
    channels_.SetAllowed(list, actions);
  }
  shared_.PostActions(std::move(actions));
}

void SubscriberEndpoint::AskAgain(const InboundCore* core) {
  Actions actions;
  {
    const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
    channels_.AskAgain(core, actions);
  }
  shared_.PostActions(std::move(actions));
}

LeaderPool::Task SubscriberEndpoint::Serve(bool& busy) {
  if (bytes_.load() && bytes_.exchange(false)) unfinished_.NoteBytes(std::chrono::steady_clock::now());
  if (inbox_.empty() && (input_.load() || monitor_input_.load())) {
    input_ = false;
    if (ReadBatch()) {
      input_ = true;  // Stays set until a batch finds nothing more.
      busy = true;
    }
  }
  if (inbox_.empty()) return {};
  busy = true;
  return inbox_.DeliverAll(shared_, connection_.endpoint());
}

bool SubscriberEndpoint::ReadBatch() {
  const std::scoped_lock lock(mutex_);
  Actions actions;
  // Before the messages: those that came before the connection has ended are there, then.
  if (monitor_input_.exchange(false)) {
    ReadMonitor(actions);
    inbox_.AddActions(actions);
  }
  inbox_.AddActions(last_);
  Socket& socket = connection_.socket();
  Message topic;
  std::vector<Message> frames;
  for (int i = 0; i < kMessagesPerTurn; ++i) {
    if (!socket.Receive(topic)) {
      TakeEnd(actions);
      inbox_.AddActions(actions);
      return false;
    }
    frames.clear();
    bool more = topic.more();
    while (more) {
      Message frame;
      if (!socket.Receive(frame)) break;
      more = frame.more();
      if (frames.size() < 3) frames.push_back(std::move(frame));
    }
    unfinished_.NoteMessage();
    publisher_.last_heard = std::chrono::steady_clock::now();
    const std::string_view text = AsText(topic.bytes());
    if (!text.empty() && text[0] == kControlByte) {
      if (ParseControlTopic(text) != shared_.self.info.id) {
        shared_.CountFault(PacketFault::kTopic, endpoint(), "a control message for another session");
        continue;
      }
      OnControl(frames, actions);
    } else if (const auto read = packets_.Read(topic, frames); read == PacketReader::Result::kTooMuch) {
      AbortConnection("it sent more than it had credit for", true, actions);
    } else if (read == PacketReader::Result::kGap) {
      OnGap(actions);
    }
    if (connection_.CollectUnread()) {
      shared_.CountPeerFault(PacketFault::kOverrun, endpoint(),
                             "it does not read the answers to its messages, so the connection is closed for 5 s. Find "
                             "the program");
      AbortConnection("it does not read", true, actions, kPauseAfterFault);
    }
    if (!actions.empty()) inbox_.AddActions(actions);
  }
  return true;
}

// What comes over a new connection before its Welcome is no gap: it comes again.
void SubscriberEndpoint::OnGap(Actions& actions) {
  ReadMonitor(actions);
  if (end_waits_ || ended_) return;
  shared_.CountPeerFault(PacketFault::kTopic, endpoint(), "one before it is lost, so the connection is made again");
  AbortConnection("a message was lost", false, actions);
}

void SubscriberEndpoint::ReadMonitor(Actions& actions) {
  const bool ended = connection_.ReadMonitor();
  if (const auto connection = connection_.CollectConnection()) {
    ended_ = *connection < 0;
    unfinished_.Watch(*connection);
    WaitForBytes();
  }
  if (connection_.CollectFailure()) Report(EndpointEvent::kFailed, actions);
  end_waits_ = end_waits_ || ended;
}

void SubscriberEndpoint::TakeEnd(Actions& actions) {
  if (!std::exchange(end_waits_, false)) return;
  channels_.SetPlain(false);
  LosePublisher("the connection was closed", false, actions);
}

void SubscriberEndpoint::Report(EndpointEvent event, Actions& actions) const {
  if (!on_event_) return;
  actions.emplace_back([report = on_event_, event, who = publisher_.facts.info.id] { report(event, who); });
}

void SubscriberEndpoint::AbortConnection(std::string_view reason, bool for_good, Actions& actions,
                                         std::chrono::milliseconds pause) {
  LosePublisher(reason, for_good, actions);
  connection_.Abort(pause);
  unfinished_.Watch(-1);
}

// Once: then the looks begin. A closed descriptor leaves the poller by itself.
void SubscriberEndpoint::WaitForBytes() noexcept {
  if (unfinished_.connection() >= 0) (void)poller_.AddOnce(unfinished_.connection(), bytes_);
}

void SubscriberEndpoint::Look(SteadyTime now) {
  Actions actions;
  {
    const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
    const auto fault = unfinished_.Look(now, !connection_.socket().HasInput());
    if (fault) {
      shared_.CountPeerFault(PacketFault::kOverrun, endpoint(),
                             "the message " + *fault + " The connection is closed, and tried again after 5 s.");
      AbortConnection("it sent a message that does not end", true, actions, kPauseAfterFault);
    } else if (!unfinished_.NextLook()) {
      WaitForBytes();
    }
  }
  inbox_.AddActions(actions);
}

void SubscriberEndpoint::OnControl(const std::vector<Message>& frames, Actions& actions) {
  const auto control = frames.size() == 1 ? ParseControl(frames[0].bytes()) : std::nullopt;
  if (!control) {
    shared_.CountFault(PacketFault::kHead, endpoint(), "a control message that does not parse");
    return;
  }
  const SessionId session{control->session()};
  if (control->has_welcome()) {
    OnWelcome(session, control->welcome(), actions);
    return;
  }
  if (publisher_.id() != session) return;
  if (!publisher_.alive) {
    // We have dropped this publisher, and it does not know that, or did not run for a while.
    if (connection_.connected() && !control->has_bye()) SayHello(0);
    return;
  }
  switch (control->what_case()) {
    case wire::Control::kSubscribed: channels_.OnSubscribed(control->subscribed(), actions); break;
    case wire::Control::kRefused: channels_.OnRefused(control->refused(), actions); break;
    case wire::Control::kWithdrawn: channels_.OnWithdrawn(control->withdrawn().channel(), actions); break;
    case wire::Control::kOffers:
      publisher_.UpdateOffers(control->offers());
      shared_.AddChannelsChanged(actions);
      break;
    case wire::Control::kHeartbeat: OnHeartbeat(control->heartbeat(), actions); break;
    case wire::Control::kBye: LosePublisher("it said goodbye", true, actions); break;
    default: shared_.CountFault(PacketFault::kHead, endpoint(), "a subscriber's control message");
  }
}

void SubscriberEndpoint::OnWelcome(SessionId session, const wire::Welcome& welcome, Actions& actions) {
  // The monitor's events from before this message have arrived by now; they are handled first.
  ReadMonitor(actions);
  TakeEnd(actions);
  if (ended_) return;  // The answers would wait for the next connection.
  connection_.SetWelcomed();
  channels_.SetPlain(false);
  if (!shared_.MayClaim(session, connection_.server_key(), endpoint())) return;
  if (session == shared_.self.info.id) {
    shared_.log.WriteLimited(
        LogLevel::kDebug, "zmq self " + endpoint(),
        "The subscribe endpoint " + endpoint() + " is this session's own: nothing is received there.",
        std::chrono::hours(24));
    return;
  }
  if (welcome.facts().wire_major() != kWireMajor) {
    shared_.CountFault(PacketFault::kVersion, endpoint(),
                       "the publisher speaks version " + std::to_string(welcome.facts().wire_major()));
    return;
  }
  SessionFacts facts = ReadFacts(session, welcome.facts());
  facts.info.endpoint = endpoint();
  if (publisher_.known() && (publisher_.id() != session || publisher_.facts.incarnation != facts.incarnation)) {
    LosePublisher("another session took its place", true, actions);
    if (publisher_.id() != session) actions.emplace_back([this, old = publisher_.id()] { replaced_(old); });
    publisher_ = {};
  }
  if (!publisher_.alive && !connection_.NoteSession()) {
    shared_.CountPeerFault(PacketFault::kOverrun, endpoint(),
                           "more than " + std::to_string(PublisherConnection::kMostSessions) +
                               " sessions came and went over one connection in 10 s. The connection is closed, and "
                               "tried again after 5 s. Find the program.");
    connection_.Abort(kPauseAfterFault);
    unfinished_.Watch(-1);
    return;
  }
  const bool came = !std::exchange(publisher_.alive, true);
  publisher_.facts = std::move(facts);
  publisher_.handshake = welcome.handshake();
  publisher_.last_heard = std::chrono::steady_clock::now();
  connection_.SetConnected();
  if (came) {
    actions.emplace_back([this, info = publisher_.facts.info] { shared_.peers.Came(info); });
    Report(EndpointEvent::kReached, actions);
  }
  SayHello(welcome.handshake());
  publisher_.offers.clear();
  for (const auto& offered : welcome.offers()) publisher_.AddOffer(offered);
  shared_.AddChannelsChanged(actions);
  channels_.AskForAll();
}

void SubscriberEndpoint::OnHeartbeat(const wire::Heartbeat& heartbeat, Actions& actions) {
  const Time now = shared_.Wall();
  if (auto answer = AnswerTo(heartbeat, now)) {
    auto message = ControlFrom(shared_.self.info.id);
    *message.mutable_heartbeat() = std::move(*answer);
    connection_.Send(message);
  }
  if (const auto exchange = publisher_.clock.Read(heartbeat, now)) {
    actions.emplace_back(
        [this, info = publisher_.facts.info, told = *exchange] { shared_.listener.OnClockExchange(info, told); });
  }
}

void SubscriberEndpoint::SayHello(std::uint64_t handshake) {
  auto message = ControlFrom(shared_.self.info.id);
  WriteFacts(shared_.self, *message.mutable_hello()->mutable_facts());
  message.mutable_hello()->set_handshake(handshake);
  if (handshake != 0) message.mutable_hello()->set_proof(shared_.ProofFor(publisher_.id()));
  connection_.Send(message);
}

void SubscriberEndpoint::LosePublisher(std::string_view reason, bool for_good, Actions& actions) {
  if (!publisher_.known()) return;
  const bool freed = channels_.OnPublisherLost(for_good, actions);
  if (std::exchange(publisher_.alive, false)) {
    actions.emplace_back(
        [this, info = publisher_.facts.info, text = std::string(reason)] { shared_.peers.Gone(info, text); });
    shared_.AddChannelsChanged(actions);
    Report(EndpointEvent::kLost, actions);
  }
  if (freed) channels_.AddClaimsFreed(actions);
}

void SubscriberEndpoint::AddOffers(std::vector<SessionChannels>& known) const {
  const std::scoped_lock lock(mutex_);
  publisher_.AddOffers(known);
}

void SubscriberEndpoint::SendCredit(bool all) {
  // Does not touch the socket unless the publisher waits for credit.
  if (!all && !channels_.IsCreditDue()) return;
  {
    const std::scoped_lock lock(mutex_);
    if (!publisher_.alive) return;
  }
  const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
  if (publisher_.alive && connection_.connected()) channels_.SendCredit(all);
}

OrderWay SubscriberEndpoint::SendOrder(SessionId publisher, std::string_view request) {
  const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
  if (!publisher_.alive || publisher_.id() != publisher || !connection_.connected()) return OrderWay::kNone;
  // Another transport that reaches the publisher, or will, may be trusted more.
  if (shared_.options.takes && !shared_.options.takes(publisher, kOrdersChannel)) return OrderWay::kNone;
  if (publisher_.facts.wire_minor < kOrdersSinceMinor) return OrderWay::kTooOld;
  if (request.size() > kMaxOrderBytes) return OrderWay::kNone;
  auto message = ControlFrom(shared_.self.info.id);
  message.mutable_order()->set_request(request.data(), request.size());
  connection_.Send(message);
  return OrderWay::kSent;
}

void SubscriberEndpoint::Tick(SteadyTime now) {
  Actions actions;
  {
    const SocketUse use(mutex_, connection_.socket(), input_, *shared_.waker);
    if (connection_.TurnPlain(now)) channels_.SetPlain(true);
    connection_.Tick(now);
    if (unfinished_.HasReceived()) publisher_.last_heard = now;
    if (publisher_.alive) shared_.silence.Note(publisher_.facts.info, publisher_.last_heard);
    const auto timeout = shared_.options.peer_timeout;
    if (publisher_.alive && now - publisher_.last_heard > timeout) {
      LosePublisher("it was silent for " + std::to_string(timeout.count()) + " ms", false, actions);
    }
    if (connection_.IsLeftAlone(now, publisher_.last_heard)) {
      shared_.log.WriteLimited(LogLevel::kWarning, "zmq left " + endpoint(),
                               "Nothing comes over the connection to " + endpoint() + " any more. It is made again.");
      AbortConnection("nothing came over the connection", false, actions);
    }
    if (connection_.connected() && publisher_.known() && connection_.welcomed()) {
      auto message = ControlFrom(shared_.self.info.id);
      publisher_.clock.Ask(*message.mutable_heartbeat(), shared_.Wall());
      connection_.Send(message);
    }
  }
  // Calls go through the inbox, so that they keep their order with what was read before.
  inbox_.AddActions(actions);
  SendCredit(true);
}

std::optional<SteadyTime> SubscriberEndpoint::Deadline() const {
  const std::scoped_lock lock(mutex_);
  return connection_.Deadline();
}

void SubscriberEndpoint::ForgiveSilence(SteadyTime now) {
  const std::scoped_lock lock(mutex_);
  publisher_.last_heard = now;
}

bool SubscriberEndpoint::LeadAlike(const SubscriberEndpoint& one, const SubscriberEndpoint& other) {
  if (&one == &other) return false;
  const std::scoped_lock lock(one.mutex_, other.mutex_);
  const RemotePublisher& first = one.publisher_;
  const RemotePublisher& second = other.publisher_;
  return first.alive && second.alive && first.id() == second.id() && AreOfOneSocket(first.handshake, second.handshake);
}

void SubscriberEndpoint::Close(int linger_ms, bool others, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  if (!publisher_.alive || !connection_.connected()) {
    linger_ms = 0;  // Only subscriptions for the next connection are waiting: they need no delay.
  } else if (others) {
    channels_.DropAll(actions);
  } else {
    auto bye = ControlFrom(shared_.self.info.id);
    bye.mutable_bye()->set_unsubscribes(shared_.leaving);
    connection_.Send(bye);
  }
  LosePublisher("the endpoint was closed", true, actions);
  connection_.Close(linger_ms);
}

void SubscriberEndpoint::SetLastActions(Actions&& actions) {
  const std::scoped_lock lock(mutex_);
  last_ = std::move(actions);
  input_ = true;
}

}  // namespace hgros::zmq
