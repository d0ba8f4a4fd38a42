#include "transport/zmq/publish/publisher_endpoint.hpp"

#include <utility>

#include "hgros/base/readable_text.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/connection.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/curve.hpp"
#include "transport/zmq/endpoint.hpp"
#include "transport/zmq/socket_use.hpp"

namespace hgros::zmq {
namespace {

constexpr int kWaitingUpstream = 4;
constexpr int kAskAfterS = 2;
constexpr int kAskAgainAfterS = 5;
constexpr int kMostQuestions = 127;  // The most that the kernel allows.
constexpr int kFramesPerTurn = 64;   // Then other endpoints have their turn.

}  // namespace

PublisherEndpoint::PublisherEndpoint(SharedState& shared, const PublishEndpoint& endpoint, TakeOrder take_order)
    : shared_(shared),
      take_order_(std::move(take_order)),
      endpoint_(FullEndpoint(endpoint.endpoint)),
      socket_(shared.context, ZMQ_XPUB),
      watch_(shared, socket_, bound_),
      channels_(shared, socket_, endpoint.channels),
      peers_(shared, socket_, channels_, watch_, bound_),
      subscriptions_(shared, channels_, peers_, [this](const auto& core, SessionId session, std::uint64_t link) {
        FetchLatched(core, session, link);
      }) {
  // Credit limits the messages in flight. ZeroMQ's own limits would silently drop the newest messages.
  socket_.Set(ZMQ_SNDHWM, 0);
  // ZeroMQ takes all subscriptions of a connection that wait before it returns the first one. With this limit its
  // thread stops reading meanwhile, so the subscriber waits and its limits are seen in time. But ZeroMQ ends the
  // process if such a connection has an error and a PING waits. So connections never have errors (docs/decisions/0050),
  // except for those of ipc, which have no limit: there only programs of the same user can connect.
  socket_.Set(ZMQ_RCVHWM, endpoint_.starts_with("ipc:") ? 0 : kWaitingUpstream);
  // Reports every subscription and unsubscription, even if another connection has it: AcceptedConnections counts them.
  // After a reconnect the old connection may end after the new one has begun.
  socket_.Set(ZMQ_XPUB_VERBOSER, 1);
  socket_.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(kMaxUpstreamBytes));
  // The kernel asks connections that are silent, because it hears nothing of one that was reset.
  socket_.Set(ZMQ_TCP_KEEPALIVE, 1);
  socket_.Set(ZMQ_TCP_KEEPALIVE_IDLE, kAskAfterS);
  socket_.Set(ZMQ_TCP_KEEPALIVE_INTVL, kAskAgainAfterS);
  socket_.Set(ZMQ_TCP_KEEPALIVE_CNT, kMostQuestions);
  // With a domain, ZeroMQ refuses ZMTP before 3.0. Otherwise it takes arbitrary bytes for messages of ZMTP 1.0, some of
  // them for subscriptions. When such a connection ends it looks through the topics of all, in whatever call is next:
  // so a flood of them held a publishing thread for 40 s.
  socket_.Set(ZMQ_ZAP_DOMAIN, "hgros");
  if (shared.options.security) SecureServer(socket_, *shared.options.security);
  SetFamily(socket_, endpoint_);
  BindOrThrow(socket_, endpoint_);
  bound_ = socket_.LastEndpoint();
  (void)watch_.Serve();
  fd_ = socket_.Fd();
}

PublisherEndpoint::~PublisherEndpoint() = default;

void PublisherEndpoint::Offer(const std::shared_ptr<OutboundCore>& core) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *shared_.waker);
    auto& channel = channels_.Add(core);
    if (channel.allowed) subscriptions_.OpenChannel(channel, actions);
  }
  shared_.PostActions(std::move(actions));
}

void PublisherEndpoint::Withdraw(const std::shared_ptr<OutboundCore>& core, Actions& actions) {
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  auto* channel = channels_.Find(core);
  if (channel == nullptr) return;
  subscriptions_.CloseChannel(*channel, actions);
  channels_.Remove(*core);
}

void PublisherEndpoint::SetChannels(const ChannelList& list) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *shared_.waker);
    for (auto* channel : channels_.SetAllowed(list)) {
      if (channel->allowed) {
        subscriptions_.OpenChannel(*channel, actions);
      } else {
        subscriptions_.CloseChannel(*channel, actions);
      }
    }
  }
  shared_.PostActions(std::move(actions));
}

void PublisherEndpoint::CancelReservation(const std::shared_ptr<OutboundCore>& core) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    channels_.CancelReservation(core, actions);
  }
  shared_.PostActions(std::move(actions));
}

void PublisherEndpoint::Commit(const std::shared_ptr<OutboundCore>& core,
                               const std::shared_ptr<const WireMessage>& message, PeerChannel::Dropped& ended) {
  Actions actions;
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  channels_.Commit(core, message, ended, actions);
  if (channels_.IsPlainSlow(*core)) watch_.CutStuckPlain(std::chrono::steady_clock::now());
  if (!actions.empty()) shared_.PostActions(std::move(actions));
}

void PublisherEndpoint::FetchLatched(const std::shared_ptr<OutboundCore>& core, SessionId session, std::uint64_t link) {
  std::vector<PendingMessage> latched;
  const bool open = core->gate.Through([&] {
    for (const auto& message : core->source.Latched(session)) {
      auto wire = std::make_shared<const WireMessage>(message.head, message.data);
      const std::uint64_t bytes = wire->bytes();
      latched.push_back({std::move(wire), message.head.id, bytes});
    }
  });
  if (!open) return;
  const PeerChannel::Dropped held = latched;  // Those that are not needed are destroyed after the lock.
  PeerChannel::Dropped ended;
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  subscriptions_.BeginLink(*core, session, link, std::move(latched), ended);
}

bool PublisherEndpoint::Serve(Actions& actions) {
  if (!pending()) return false;
  const std::scoped_lock lock(mutex_);
  // Watching may use the socket, and with it the signal that input has arrived.
  const bool watched = watch_.input().load();
  const bool more = watch_.Serve();
  const bool looks = watch_.unfinished().IsLookDue();
  if (!input_.exchange(false) && !looks && !watched) return more;
  Message frame;
  for (int i = 0; i < kFramesPerTurn; ++i) {
    if (!socket_.Receive(frame)) {
      if (looks) watch_.CutUnfinished();
      watch_.unfinished().SettleDelivered(std::chrono::steady_clock::now());
      return more;
    }
    watch_.unfinished().NoteMessage(zmq_msg_get(frame.raw(), ZMQ_SRCFD));
    if (!frame.more()) {
      OnFrame(frame, actions);
      for (const SessionId session : watch_.CollectGivenUp()) {
        peers_.Drop(session, "too many channels are asked for, and it is not connected", actions);
      }
      continue;
    }
    // No session sends several frames in this direction.
    while (frame.more() && socket_.Receive(frame)) {
    }
    shared_.CountFault(PacketFault::kLength, bound_, "a control message of several frames");
  }
  input_ = true;
  return true;
}

void PublisherEndpoint::OnFrame(Message& frame, Actions& actions) {
  const std::string_view text = AsText(frame.bytes());
  if (text.empty()) {
    shared_.CountFault(PacketFault::kTruncated, bound_, "an empty control message");
  } else if (text[0] == '\0' || text[0] == '\1') {
    OnTopic(text[0] == '\1', text.substr(1), frame, actions);
  } else if (text[0] == kControlByte) {
    OnUpstream(frame, actions);
  } else {
    shared_.CountFault(PacketFault::kHead, bound_, "not a control message");
  }
}

void PublisherEndpoint::OnTopic(bool subscribed, std::string_view text, Message& frame, Actions& actions) {
  if (!watch_.CountTopic(zmq_msg_get(frame.raw(), ZMQ_SRCFD), text, subscribed)) return;
  if (const auto session = ParseControlTopic(text)) {
    if (subscribed) {
      if (!MayClaim(*session, frame)) {
        HangUp(frame, bound_);
      } else if (watch_.NoteSession(zmq_msg_get(frame.raw(), ZMQ_SRCFD), *session)) {
        peers_.Greet(*session, zmq_msg_get(frame.raw(), ZMQ_SRCFD), true);
      }
    } else {
      peers_.OnDisconnected(*session, actions);
    }
    return;
  }
  const auto topic = ParseTopic(AsBytes(text));
  if (!topic) {
    if (subscribed) RefuseFilter(text, frame);
    return;
  }
  // A session sends a Subscribe for each peer topic that it wants.
  if (topic->session.value != 0) {
    if (subscribed && !MayClaim(topic->session, frame)) HangUp(frame, bound_);
    return;
  }
  if (subscribed) watch_.NotePlain(zmq_msg_get(frame.raw(), ZMQ_SRCFD));
  channels_.SetPlainTopic(topic->channel, subscribed, bound_, actions);
}

// ZeroMQ matches a filter as a prefix. So this connection would get packets for sessions, and nothing would limit how
// many of them wait for it. ZeroMQ 4.3 has no sound way to give a connection another filter than it asks for.
void PublisherEndpoint::RefuseFilter(std::string_view filter, Message& frame) {
  HangUp(frame, bound_);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq filter " + bound_,
                           "A plain subscriber at " + bound_ + " asks for all topics that begin with \"" +
                               Readable(filter, kMaxTextBytes) +
                               "\", which is not a whole topic: its connection is closed. Let it subscribe to the "
                               "name of a channel followed by a zero byte.",
                           std::chrono::hours(1));
}

bool PublisherEndpoint::MayClaim(SessionId session, const Message& frame) {
  if (!shared_.options.security) return true;
  const std::string_view from = frame.peer_address();  // Empty with ipc.
  return shared_.MayClaim(session, frame.user_id(), from.empty() ? bound_ : std::string(from) + " at " + bound_);
}

void PublisherEndpoint::OnUpstream(Message& frame, Actions& actions) {
  auto control = ParseControl(frame.bytes().subspan(1));
  if (!control) {
    shared_.CountFault(PacketFault::kHead, bound_, "a control message that does not parse");
    return;
  }
  const SessionId session{control->session()};
  if (!MayClaim(session, frame)) return;
  const int fd = zmq_msg_get(frame.raw(), ZMQ_SRCFD);
  if (control->has_hello()) {
    if (watch_.NoteSession(fd, session)) peers_.OnHello(session, control->hello(), fd, actions);
    return;
  }
  SubscriberPeer* peer = peers_.Find(session);
  if (peer != nullptr && !watch_.MaySpeakFor(fd, session, peer->proof)) {
    shared_.CountFault(PacketFault::kHead, bound_,
                       "a message in the name of " + peer->name() + ", which has another connection");
    return;
  }
  if (peer == nullptr) {
    // We have dropped this session, and it does not know that.
    if (!control->has_bye()) peers_.Greet(session, fd, false);
    return;
  }
  peer->last_heard = std::chrono::steady_clock::now();
  switch (control->what_case()) {
    case wire::Control::kSubscribe:
      subscriptions_.OnSubscribe(*peer, control->subscribe(), fd, actions);
      if (!watch_.CountWishes(fd, session, peer->wish_bytes)) {
        peers_.Drop(session, "it asked for too many channels", actions);
      }
      break;
    case wire::Control::kUnsubscribe:
      subscriptions_.OnUnsubscribe(*peer, control->unsubscribe(), fd, actions);
      (void)watch_.CountWishes(fd, session, peer->wish_bytes);
      break;
    case wire::Control::kCredit: subscriptions_.OnCredit(*peer, control->credit(), actions); break;
    case wire::Control::kOrder: OnOrder(*peer, std::move(*control->mutable_order()), frame, actions); break;
    case wire::Control::kHeartbeat: peers_.OnHeartbeat(*peer, control->heartbeat(), actions); break;
    case wire::Control::kBye: {
      using End = PublishedChannels::LinkEnd;
      peers_.Drop(session, "it said goodbye", actions, control->bye().unsubscribes() ? End::kUnsubscribed : End::kLost);
      break;
    }
    default: shared_.CountPeerFault(PacketFault::kHead, peer->name(), "a publisher's control message");
  }
}

void PublisherEndpoint::OnOrder(const SubscriberPeer& peer, wire::Order&& order, const Message& frame,
                                Actions& actions) const {
  if (!channels_.IsAllowed(kOrderRepliesChannel)) return;  // The sender would not learn what became of it.
  // With keys, only those of allowed_clients come here.
  const bool trusted = shared_.options.security && !frame.user_id().empty();
  const auto request = std::make_shared<const std::string>(std::move(*order.mutable_request()));
  actions.emplace_back([take = take_order_, from = peer.facts.info.id, trusted, request] {
    InboundMessage message;
    message.from = from;
    message.trusted = trusted;
    message.data = {AsBytes(*request), request};
    take(std::move(message));
  });
}

void PublisherEndpoint::Tick(SteadyTime now, Actions& actions) {
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  peers_.Tick(now, actions);
  watch_.Tick();
}

void PublisherEndpoint::OnReplaced(SessionId session, Actions& actions) {
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  peers_.OnReplaced(session, actions);
}

void PublisherEndpoint::ForgiveSilence(SteadyTime now) {
  const std::scoped_lock lock(mutex_);
  peers_.ForgiveSilence(now);
}

std::size_t PublisherEndpoint::Unfinished(const OutboundCore& core) const {
  const std::scoped_lock lock(mutex_);
  return channels_.Unfinished(core);
}

void PublisherEndpoint::LookAtArriving(Arriving& arriving) {
  const SocketUse use(mutex_, socket_, input_, *shared_.waker);
  peers_.LookAtArriving(arriving);
  const std::uint64_t plain = channels_.plain_bytes();
  arriving.any = arriving.any || plain > 0;
  arriving.progress -= plain;
}

void PublisherEndpoint::AddWishes(std::vector<SessionChannels>& known) const {
  const std::scoped_lock lock(mutex_);
  peers_.AddWishes(known);
}

void PublisherEndpoint::Close(int linger_ms, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  if (shared_.closing) peers_.AddUnconfirmed(shared_.unconfirmed);
  peers_.DropAll("the endpoint was closed", actions);
  if (socket_.closed()) return;
  const bool listens = watch_.listens();
  watch_.Close();
  if (listens) {
    CloseListening(shared_.context, socket_, linger_ms);
  } else {
    socket_.Close(linger_ms);
  }
}

}  // namespace hgros::zmq
