#include "transport/zmq/subscriber_endpoint.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "hgros/base/error.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/curve.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr int kMessagesInTurn = 32;  // Messages read before others have their turn.
// A link that ends leaves its messages in flight, and the next one has a window of its own: a publisher that begins
// one after another has so many of them at most.
constexpr std::uint64_t kWindowsInFlight = 4;
constexpr int kReconnectMs = 100;
constexpr int kReconnectMaxMs = 1000;

}  // namespace

SubscriberEndpoint::SubscriberEndpoint(Carrier& carrier, const SubscribeEndpoint& endpoint,
                                       std::function<void()> claims_freed)
    : carrier_(carrier),
      endpoint_(FullEndpoint(endpoint.endpoint)),
      claims_freed_(std::move(claims_freed)),
      socket_(carrier.context, ZMQ_XSUB),
      monitor_(carrier.context, ZMQ_PAIR) {
  if (endpoint.channels) allowed_.emplace(endpoint.channels->begin(), endpoint.channels->end());
  socket_.Set(ZMQ_SNDHWM, 0);
  socket_.Set(ZMQ_RCVHWM, 0);
  socket_.Set(ZMQ_RECONNECT_IVL, kReconnectMs);
  socket_.Set(ZMQ_RECONNECT_IVL_MAX, kReconnectMaxMs);
  socket_.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(carrier.options.max_message_bytes));
  socket_.Set(ZMQ_TCP_KEEPALIVE, 1);
  socket_.Set(ZMQ_TCP_MAXRT, static_cast<int>(2 * carrier.options.peer_timeout.count()));
  if (carrier.options.security) SecureClient(socket_, *carrier.options.security, endpoint.server_key);

  const std::string monitored = "inproc://monitor-" + std::to_string(RandomId());
  if (zmq_socket_monitor(socket_.raw(), monitored.c_str(),
                         ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_CONNECT_RETRIED |
                             ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                             ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) != 0) {
    throw Error(std::string("Cannot watch the connection to ") + endpoint_ + ": " + zmq_strerror(zmq_errno()) + ".");
  }
  if (const int error = monitor_.Connect(monitored); error != 0) {
    throw Error(std::string("Cannot watch the connection to ") + endpoint_ + ": " + zmq_strerror(error) + ".");
  }
  SubscribeTopic(ControlTopic(carrier.self.info.id), true);
  if (const int error = socket_.Connect(endpoint_); error != 0) {
    throw Error("Cannot subscribe at " + endpoint_ + ": " + zmq_strerror(error) + ".", {},
                "Write it as tcp://address:port or ipc:///path.");
  }
  fd_ = socket_.Fd();
  monitor_fd_ = monitor_.Fd();
}

SubscriberEndpoint::~SubscriberEndpoint() = default;

bool SubscriberEndpoint::Allowed(const std::string& channel) const {
  return !allowed_ || allowed_->contains(ListedAs(channel));
}

void SubscriberEndpoint::SubscribeTopic(std::string topic, bool subscribe) {
  topic.insert(topic.begin(), subscribe ? '\1' : '\0');
  socket_.Send(topic, false);
}

void SubscriberEndpoint::SetPlain(Link& link, bool plain) {
  if (link.plain == plain) return;
  link.plain = plain;
  // One account for all connections: what an earlier one left is still in flight.
  if (plain && !link.plain_credit) link.plain_credit = std::make_shared<LinkCredit>(0, 0, carrier_.waker);
  SetPlainWindow(link);
  SubscribeTopic(link.core->plain_topic, plain);
}

void SubscriberEndpoint::SetPlainWindow(const Link& link) {
  if (!link.plain_credit) return;
  // A session would keep the rest of the queue's depth for us.
  const Demand demand = link.core->demand();
  link.plain_credit->SetWindow(std::max({demand.credit_messages, demand.queue_depth, 1u}),
                               std::max<std::uint64_t>(demand.credit_bytes, 1));
}

void SubscriberEndpoint::Want(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  Link& link = links_[core->name];
  link.core = core;
  link.allowed = Allowed(core->name);
  if (!link.allowed) return;
  if (plain_mode_) SetPlain(link, true);
  Ask(link);
}

void SubscriberEndpoint::Unwant(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  const auto found = links_.find(core->name);
  if (found == links_.end() || found->second.core != core) return;
  Actions nobody_listens;
  StopAsking(found->second, {}, nobody_listens);
  links_.erase(found);
}

void SubscriberEndpoint::ChangeDemand(const std::shared_ptr<InboundCore>& core) {
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  const auto found = links_.find(core->name);
  if (found == links_.end() || found->second.core != core) return;
  SetPlainWindow(found->second);
  if (found->second.asked) SendSubscribe(found->second, true);
}

void SubscriberEndpoint::SetChannels(const ChannelList& list) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
    allowed_.reset();
    if (list) allowed_.emplace(list->begin(), list->end());
    for (auto& [name, link] : links_) {
      const bool allowed = Allowed(name);
      if (allowed == link.allowed) continue;
      link.allowed = allowed;
      if (allowed) {
        if (plain_mode_) SetPlain(link, true);
        Ask(link);
      } else {
        StopAsking(link, {}, actions);
      }
    }
  }
  carrier_.Post(std::move(actions));
}

void SubscriberEndpoint::AskAgain() {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
    for (auto& [name, link] : links_) {
      const bool moved = link.asked && publisher_ && carrier_.options.takes &&
                         !carrier_.options.takes(publisher_->facts.info.id, name);
      if (moved) {
        StopAsking(link, {}, actions);
      } else {
        Ask(link);
      }
    }
  }
  carrier_.Post(std::move(actions));
}

void SubscriberEndpoint::AddActions(Actions& actions) {
  for (auto& action : actions) inbox_.push_back({.core = {}, .packet = {}, .action = std::move(action)});
  actions.clear();
}

LeaderPool::Task SubscriberEndpoint::Serve(bool& busy) {
  if (inbox_.empty() && (input_.load() || monitor_input_.load())) {
    input_ = false;
    if (ReadBatch()) {
      input_ = true;  // Until a batch finds nothing more.
      busy = true;
    }
  }
  while (!inbox_.empty()) {
    busy = true;
    Arrival arrival = std::move(inbox_.front());
    inbox_.pop_front();
    if (!arrival.core) {
      arrival.action();
      continue;
    }
    auto task = Deliver(arrival.core, std::move(arrival.packet), carrier_, endpoint_);
    if (task) return task;
  }
  return {};
}

bool SubscriberEndpoint::ReadBatch() {
  const std::scoped_lock lock(mutex_);
  Actions actions;
  if (monitor_input_.exchange(false)) {
    OnMonitor(actions);
    AddActions(actions);
  }
  AddActions(last_);
  Message topic;
  std::vector<Message> frames;
  for (int i = 0; i < kMessagesInTurn; ++i) {
    if (!socket_.Receive(topic)) return false;
    frames.clear();
    bool more = topic.more();
    while (more) {
      Message frame;
      if (!socket_.Receive(frame)) break;
      more = frame.more();
      if (frames.size() < 3) frames.push_back(std::move(frame));
    }
    if (publisher_) publisher_->last_heard = std::chrono::steady_clock::now();
    const std::string_view text = AsText(topic.bytes());
    if (!text.empty() && text[0] == kControlByte) {
      if (ParseControlTopic(text) != carrier_.self.info.id) {
        carrier_.CountFault(PacketFault::kTopic, endpoint_, "a control message for another session");
        continue;
      }
      OnControl(frames, actions);
      AddActions(actions);
    } else {
      OnData(topic, frames);
    }
  }
  return true;
}

void SubscriberEndpoint::OnData(Message& topic_frame, std::vector<Message>& frames) {
  const auto topic = ParseDataTopic(topic_frame.bytes());
  if (!topic || (topic->session.value != 0 && topic->session != carrier_.self.info.id)) {
    const auto fault = frames.size() < 2 ? PacketFault::kTruncated : PacketFault::kTopic;
    carrier_.CountFault(fault, endpoint_, "its first frame is not a topic of ours");
    return;
  }
  const auto found = links_.find(std::string(topic->channel));
  if (found == links_.end()) return;  // Just unsubscribed.
  Link& link = found->second;
  InboundPacket packet;
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(frames.size(), 2); ++i) bytes += frames[i].bytes().size();
  if (topic->session.value != 0) {
    if (link.id == 0 || !publisher_ || topic->number != link.credit->received().messages + 1) return;
    if (!link.credit->HadRoom()) {
      OnOverdraft(link);
      return;
    }
    if (IsCrowded(link)) {
      link.credit->Skip(bytes);
      Drop(link, PacketFault::kOverrun, "the publisher's earlier links have left too much in flight", {});
      return;
    }
    packet.credit = link.credit->Take(bytes);
    packet.from = publisher_->facts.info.id;
    packet.fingerprint = link.fingerprint;
    packet.schema = link.schema;
  } else if (!link.plain) {
    return;  // Asked for before the publisher turned out to be a session.
  } else if (!link.plain_credit->HasRoom()) {
    Drop(link, PacketFault::kOverrun, "a plain publisher sends faster than it is read", {});
    return;
  } else {
    packet.credit = link.plain_credit->Take(bytes);
  }
  if (frames.size() != 2) {
    const auto fault = frames.size() < 2 ? PacketFault::kTruncated : PacketFault::kLength;
    Drop(link, fault, "a packet has three frames", std::move(packet.credit));
    return;
  }
  packet.head = std::move(frames[0]);
  packet.data = std::move(frames[1]);
  inbox_.push_back({.core = link.core, .packet = std::move(packet), .action = {}});
}

bool SubscriberEndpoint::IsCrowded(Link& link) {
  if (link.earlier.empty()) return false;
  std::erase_if(link.earlier, [](const auto& one) { return one.expired(); });
  LinkCredit::Totals sum = link.credit->in_flight();
  for (const auto& one : link.earlier) {
    if (const auto credit = one.lock()) {
      const auto left = credit->in_flight();
      sum.messages += left.messages;
      sum.bytes += left.bytes;
    }
  }
  return sum.messages / kWindowsInFlight >= link.asked_messages || sum.bytes / kWindowsInFlight >= link.asked_bytes;
}

void SubscriberEndpoint::Drop(const Link& link, PacketFault fault, std::string_view what,
                              std::shared_ptr<const void> credit) {
  Actions actions;
  actions.emplace_back([this, core = link.core, fault, said = std::string(what), held = std::move(credit)] {
    Fault(*core, carrier_, endpoint_, fault, "channel " + core->name + ": " + said);
  });
  AddActions(actions);
}

// It does not do as it was told, or is not what it says it is: nothing more is read from this connection.
void SubscriberEndpoint::OnOverdraft(const Link& link) {
  Drop(link, PacketFault::kOverrun, "the publisher sent more than it had credit for", {});
  Actions actions;
  LosePublisher("it sent more than it had credit for", true, actions);
  AddActions(actions);
  socket_.Disconnect(endpoint_);
  connected_ = false;
  given_up_since_ = unreached_since_ = std::chrono::steady_clock::now();  // Tick() connects again.
}

void SubscriberEndpoint::TellCredits(bool all) {
  if (!all) {
    // Without touching the socket if nobody waits.
    const std::scoped_lock lock(mutex_);
    if (std::ranges::none_of(links_,
                             [](auto& entry) { return entry.second.id != 0 && entry.second.credit->TakeDue(); })) {
      return;
    }
  }
  const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
  if (!publisher_ || !publisher_->alive || !connected_) return;
  for (auto& [name, link] : links_) {
    LinkCredit::Totals consumed;
    if (link.id == 0 || !link.credit->TellIfNews(consumed)) continue;
    auto said = ControlFrom(carrier_.self.info.id);
    auto& credit = *said.mutable_credit();
    credit.set_channel(name);
    credit.set_link(link.id);
    credit.set_consumed_messages(consumed.messages);
    credit.set_consumed_bytes(consumed.bytes);
    Say(said);
  }
}

bool SubscriberEndpoint::LeadAlike(const SubscriberEndpoint& one, const SubscriberEndpoint& other) {
  if (&one == &other) return false;
  const std::scoped_lock lock(one.mutex_, other.mutex_);
  return one.publisher_ && other.publisher_ && one.publisher_->alive && other.publisher_->alive &&
         one.publisher_->facts.info.id == other.publisher_->facts.info.id &&
         AreOfOneSocket(one.publisher_->handshake, other.publisher_->handshake);
}

void SubscriberEndpoint::Close(int linger_ms, bool others, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  // Without a connection nothing but subscriptions for the next one waits: that is not worth a delay.
  if (publisher_ && publisher_->alive && connected_ && others) {
    for (auto& [name, link] : links_) {
      if (link.asked) StopAsking(link, {}, actions);
    }
  } else if (publisher_ && publisher_->alive && connected_) {
    auto bye = ControlFrom(carrier_.self.info.id);
    bye.mutable_bye();
    Say(bye);
  } else {
    linger_ms = 0;
  }
  LosePublisher("the endpoint was closed", true, actions);
  zmq_socket_monitor(socket_.raw(), nullptr, 0);
  socket_.Close(linger_ms);
  monitor_.Close(0);
}

void SubscriberEndpoint::MakeLast(Actions&& actions) {
  const std::scoped_lock lock(mutex_);
  last_ = std::move(actions);
  input_ = true;
}

}  // namespace hgros::zmq
