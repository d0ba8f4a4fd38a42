// What a publisher says to a subscribe endpoint, and what it answers.
#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "hgros/codec/packet.hpp"
#include "transport/zmq/subscriber_endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr auto kGivenUpAfter = std::chrono::milliseconds(100);
constexpr std::size_t kMaxOffers = 4096;  // Of which a publisher may make us remember.

}  // namespace

void SubscriberEndpoint::Say(const wire::Control& control) { socket_.Send(UpstreamFrame(control), false); }

void SubscriberEndpoint::SayHello(std::uint64_t handshake) {
  auto said = ControlFrom(carrier_.self.info.id);
  WriteFacts(carrier_.self, *said.mutable_hello()->mutable_facts());
  said.mutable_hello()->set_handshake(handshake);
  Say(said);
}

void SubscriberEndpoint::OnMonitor(Actions& actions) {
  Message event;
  Message address;
  while (monitor_.Receive(event)) {
    if (event.more()) monitor_.Receive(address);
    std::uint16_t what = 0;
    if (event.bytes().size() < sizeof what) continue;
    std::memcpy(&what, event.bytes().data(), sizeof what);
    if (what == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
      connected_ = true;
      welcomed_ = false;
      connected_since_ = std::chrono::steady_clock::now();
      unreached_since_.reset();
      handshake_failure_ = 0;
    } else if (what == ZMQ_EVENT_DISCONNECTED) {
      if (connected_) unreached_since_ = std::chrono::steady_clock::now();
      connected_ = false;
      plain_mode_ = false;
      for (auto& [name, link] : links_) SetPlain(link, false);
      LosePublisher("the connection was closed", false, actions);
      given_up_since_ = std::chrono::steady_clock::now();
    } else if (what == ZMQ_EVENT_CONNECT_RETRIED) {
      given_up_since_.reset();
    } else if (handshake_failure_ != ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
      handshake_failure_ = what;
    }
  }
}

void SubscriberEndpoint::TellUnreachable() {
  std::string_view why = "is the other program running, is the port right, and does it bind that address?";
  if (handshake_failure_ == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
    why = "it refuses our key; have its `allowed_clients` list our public key.";
  } else if (handshake_failure_ != 0 && carrier_.options.security) {
    // Whichever side sees first that they do not fit: a wrong key and none at all look the same from here.
    why =
        "what answers there has another key than we were told, or does not encrypt; have `servers` (the endpoint's "
        "`server_key`) name the publisher's public key, and give it a `secret_key`.";
  } else if (handshake_failure_ != 0) {
    why = "what answers there asks for keys, or is no ZeroMQ; give us a `secret_key`, or check the port.";
  }
  carrier_.log.Write(LogLevel::kWarning, "No connection to " + endpoint_ + " for " +
                                             std::to_string(carrier_.options.unreachable_after.count()) +
                                             " ms: " + std::string(why));
}

void SubscriberEndpoint::OnControl(const std::vector<Message>& frames, Actions& actions) {
  const auto control = frames.size() == 1 ? ParseControl(frames[0].bytes()) : std::nullopt;
  if (!control) {
    carrier_.CountFault(PacketFault::kHead, endpoint_, "a control message that does not parse");
    return;
  }
  const SessionId session{control->session()};
  if (control->has_welcome()) {
    OnWelcome(session, control->welcome(), actions);
    return;
  }
  if (!publisher_ || publisher_->facts.info.id != session) return;
  if (!publisher_->alive) {
    // We gave it up, and it does not know, or was asleep.
    if (connected_ && !control->has_bye()) SayHello(0);
    return;
  }
  switch (control->what_case()) {
    case wire::Control::kSubscribed: OnSubscribed(control->subscribed(), actions); break;
    case wire::Control::kRefused: OnRefused(control->refused(), actions); break;
    case wire::Control::kWithdrawn: OnWithdrawn(control->withdrawn().channel(), actions); break;
    case wire::Control::kOffers: OnOffers(control->offers(), actions); break;
    case wire::Control::kHeartbeat: OnHeartbeat(control->heartbeat(), actions); break;
    case wire::Control::kBye: LosePublisher("it said goodbye", true, actions); break;
    default: carrier_.CountFault(PacketFault::kHead, endpoint_, "a subscriber's control message");
  }
}

void SubscriberEndpoint::OnHeartbeat(const wire::Heartbeat& heartbeat, Actions& actions) {
  const Time now = carrier_.Wall();
  if (auto answer = AnswerTo(heartbeat, now)) {
    auto said = ControlFrom(carrier_.self.info.id);
    *said.mutable_heartbeat() = std::move(*answer);
    Say(said);
  }
  if (const auto exchange = publisher_->clock.Read(heartbeat, now)) {
    actions.emplace_back(
        [this, info = publisher_->facts.info, told = *exchange] { carrier_.listener.OnClockExchange(info, told); });
  }
}

void SubscriberEndpoint::OnWelcome(SessionId session, const wire::Welcome& welcome, Actions& actions) {
  // All that the connection went through before this message is known to the monitor by now: first things first.
  OnMonitor(actions);
  welcomed_ = true;
  plain_mode_ = false;
  for (auto& [name, link] : links_) SetPlain(link, false);
  if (session == carrier_.self.info.id) {
    carrier_.log.WriteLimited(
        LogLevel::kInfo, "zmq self " + endpoint_,
        "The subscribe endpoint " + endpoint_ + " is this session's own: nothing is received there.",
        std::chrono::hours(24));
    return;
  }
  if (welcome.facts().wire_major() != kWireMajor) {
    carrier_.CountFault(PacketFault::kVersion, endpoint_,
                        "the publisher speaks version " + std::to_string(welcome.facts().wire_major()));
    return;
  }
  SessionFacts facts = ReadFacts(session, welcome.facts());
  facts.info.endpoint = endpoint_;
  if (publisher_ && (publisher_->facts.info.id != session || publisher_->facts.incarnation != facts.incarnation)) {
    LosePublisher("another session took its place", true, actions);
    publisher_.reset();
  }
  if (!publisher_) publisher_ = Publisher{};
  const bool came = !publisher_->alive;
  publisher_->facts = std::move(facts);
  publisher_->handshake = welcome.handshake();
  publisher_->last_heard = std::chrono::steady_clock::now();
  publisher_->alive = true;
  connected_ = true;  // The monitor may be late.
  unreached_since_.reset();
  if (came) actions.emplace_back([this, info = publisher_->facts.info] { carrier_.peers.Came(info); });
  SayHello(welcome.handshake());
  publisher_->offers.clear();
  for (const auto& offered : welcome.offers()) AddOffer(offered);
  TellChannels(actions);
  for (auto& [name, link] : links_) {
    link.asked = false;
    Ask(link);
  }
}

void SubscriberEndpoint::AddOffer(const wire::ChannelType& offered) {
  auto use = ReadUse(offered);
  if (!use || (publisher_->offers.size() >= kMaxOffers && !publisher_->offers.contains(offered.channel()))) return;
  use->publishes = true;
  publisher_->offers.insert_or_assign(offered.channel(), std::move(*use));
}

void SubscriberEndpoint::OnOffers(const wire::Offers& offers, Actions& actions) {
  for (const std::string& channel : offers.gone()) publisher_->offers.erase(channel);
  for (const auto& offered : offers.came()) AddOffer(offered);
  TellChannels(actions);
}

void SubscriberEndpoint::TellChannels(Actions& actions) {
  actions.emplace_back([this] { carrier_.listener.OnChannels(); });
}

void SubscriberEndpoint::AddOffers(std::vector<SessionChannels>& known) const {
  const std::scoped_lock lock(mutex_);
  if (!publisher_ || !publisher_->alive) return;
  SessionChannels& session = known.emplace_back(SessionChannels{publisher_->facts.info, {}});
  for (const auto& [channel, use] : publisher_->offers) session.channels.push_back(use);
}

void SubscriberEndpoint::Ask(Link& link) {
  if (!publisher_ || !publisher_->alive || !link.allowed || link.asked) return;
  if (carrier_.options.takes && !carrier_.options.takes(publisher_->facts.info.id, link.core->name)) return;
  // Until an answer says that the channel is not to be had here.
  if (!link.core->Claim(publisher_->facts.info.id, this, publisher_->handshake)) return;
  if (!link.subscribed) {
    link.subscribed = true;
    SubscribeTopic(PeerTopic(link.core->name, carrier_.self.info.id), true);
  }
  link.asked = true;
  SendSubscribe(link, false);
}

void SubscriberEndpoint::SendSubscribe(Link& link, bool change_only) {
  const Demand demand = link.core->demand();
  link.asked_messages = std::max<std::uint64_t>(link.asked_messages, demand.credit_messages);
  link.asked_bytes = std::max(link.asked_bytes, demand.credit_bytes);
  auto said = ControlFrom(carrier_.self.info.id);
  auto& subscribe = *said.mutable_subscribe();
  WriteType(link.core->name, link.core->type, *subscribe.mutable_wanted());
  subscribe.set_handshake(publisher_->handshake);
  subscribe.set_lossless(demand.lossless);
  subscribe.set_queue_depth(demand.queue_depth);
  subscribe.set_credit_messages(demand.credit_messages);
  subscribe.set_credit_bytes(demand.credit_bytes);
  subscribe.set_change_only(change_only);
  if (link.id != 0) {
    const auto received = link.credit->received();
    subscribe.set_link(link.id);
    subscribe.set_received_messages(received.messages);
    subscribe.set_received_bytes(received.bytes);
  }
  Say(said);
}

void SubscriberEndpoint::OnSubscribed(const wire::Subscribed& subscribed, Actions& actions) {
  const std::string& name = subscribed.offered().channel();
  if (subscribed.link() == 0) return;
  const auto found = links_.find(name);
  if (found != links_.end() && IsClaimedBeside(found->second)) {
    // Said to another endpoint, which leads to the same socket. It may have been asked for here before it was
    // withdrawn.
    if (found->second.subscribed) SubscribeTopic(PeerTopic(name, carrier_.self.info.id), false);
    found->second.subscribed = false;
    found->second.asked = false;
    return;
  }
  if (found == links_.end() || !found->second.asked) {
    // It remembers what was asked for before a cut, or what we have ended since: a link that nobody reads would use up
    // its credit.
    Unsubscribe(name, {});
    return;
  }
  Link& link = found->second;
  if (!link.core->Claim(publisher_->facts.info.id, this, publisher_->handshake)) {
    // It was withdrawn here, or not offered yet, and comes over another endpoint since.
    StopAsking(link, {}, actions);
    return;
  }
  const std::uint64_t window_messages = std::min<std::uint64_t>(subscribed.credit_messages(), link.asked_messages);
  const std::uint64_t window_bytes = std::min(subscribed.credit_bytes(), link.asked_bytes);
  if (link.id == subscribed.link()) {
    link.credit->SetWindow(window_messages, window_bytes);
    link.credit->Retell();
  } else {
    std::string fault;
    switch (CompareTypes(subscribed.offered(), link.core->type)) {
      case TypeFit::kEqual: break;
      case TypeFit::kEvolved:
        fault = SchemaFault(subscribed.descriptor_set(), link.core->type);
        if (fault.empty()) {
          carrier_.log.Write(LogLevel::kInfo, "Channel " + name + ": " + publisher_->facts.info.process +
                                                  " publishes another, compatible version of " + link.core->type.name +
                                                  ".");
        }
        break;
      case TypeFit::kDiffer: fault = "the types differ"; break;
    }
    if (!fault.empty()) {
      const std::string what = DescribeMismatch(subscribed.offered(), link.core->type) + ": " + fault;
      StopAsking(link, what, actions);
      link.asked = true;  // And refused: not again before the next Welcome.
      TellMismatch(name, what, actions);
      return;
    }
    link.id = subscribed.link();
    link.fingerprint = subscribed.offered().fingerprint();
    link.schema = nullptr;
    if (IsAnyType(link.core->type) || !subscribed.descriptor_set().empty()) {
      link.schema = ReadSchema(subscribed.offered(), subscribed.descriptor_set());
      InboundCore::TellOffer(link.core, publisher_->facts.info, link.schema, actions);
    }
    EndCredit(link);
    link.credit = std::make_shared<LinkCredit>(window_messages, window_bytes, carrier_.waker);
  }
  if (!link.active) {
    link.active = true;
    InboundCore::CountPublisher(link.core, 1, actions);
  }
}

void SubscriberEndpoint::OnRefused(const wire::Refused& refused, Actions& actions) {
  const auto found = links_.find(refused.offered().channel());
  if (found == links_.end() || !found->second.asked) return;
  EndLink(found->second, actions);
  ReleaseClaim(found->second, actions);
  TellMismatch(found->first, DescribeMismatch(refused.offered(), found->second.core->type), actions);
}

void SubscriberEndpoint::OnWithdrawn(const std::string& channel, Actions& actions) {
  const auto found = links_.find(channel);
  if (found == links_.end()) return;
  EndLink(found->second, actions);
  ReleaseClaim(found->second, actions);
}

bool SubscriberEndpoint::IsClaimedBeside(const Link& link) const {
  return publisher_ && link.core->IsClaimedBeside(publisher_->facts.info.id, this, publisher_->handshake);
}

void SubscriberEndpoint::ReleaseClaim(const Link& link, Actions& actions) {
  if (publisher_ && link.core->Release(publisher_->facts.info.id, this)) actions.emplace_back(claims_freed_);
}

void SubscriberEndpoint::TellMismatch(const std::string& channel, const std::string& what, Actions& actions) {
  if (!publisher_->told_mismatch.insert(channel).second) return;
  actions.emplace_back(
      [this, info = publisher_->facts.info, channel, what] { carrier_.listener.OnTypeMismatch(channel, info, what); });
}

void SubscriberEndpoint::EndLink(Link& link, Actions& actions) {
  link.id = 0;
  EndCredit(link);
  if (!link.active) return;
  link.active = false;
  InboundCore::CountPublisher(link.core, -1, actions);
}

void SubscriberEndpoint::EndCredit(Link& link) {
  const std::weak_ptr<LinkCredit> ended = link.credit;
  link.credit.reset();
  if (!ended.expired()) link.earlier.push_back(ended);
}

void SubscriberEndpoint::Unsubscribe(const std::string& channel, std::string_view mismatch) {
  auto said = ControlFrom(carrier_.self.info.id);
  said.mutable_unsubscribe()->set_channel(channel);
  said.mutable_unsubscribe()->set_mismatch(std::string(mismatch.substr(0, kMaxTextBytes)));
  Say(said);
}

void SubscriberEndpoint::StopAsking(Link& link, std::string_view mismatch, Actions& actions) {
  SetPlain(link, false);
  if (link.subscribed) {
    link.subscribed = false;
    SubscribeTopic(PeerTopic(link.core->name, carrier_.self.info.id), false);
  }
  if (link.asked && publisher_ && publisher_->alive && !IsClaimedBeside(link)) Unsubscribe(link.core->name, mismatch);
  link.asked = false;
  ReleaseClaim(link, actions);
  EndLink(link, actions);
}

void SubscriberEndpoint::LosePublisher(std::string_view reason, bool for_good, Actions& actions) {
  if (!publisher_) return;
  const SessionId id = publisher_->facts.info.id;
  bool freed = false;
  for (auto& [name, link] : links_) {
    freed = link.core->Release(id, this) || freed;
    link.asked = false;
    if (for_good) {
      EndLink(link, actions);
    } else if (link.active) {
      // The link itself stays: it may go on where it was cut.
      link.active = false;
      InboundCore::CountPublisher(link.core, -1, actions);
    }
  }
  if (publisher_->alive) {
    publisher_->alive = false;
    actions.emplace_back(
        [this, info = publisher_->facts.info, said = std::string(reason)] { carrier_.peers.Gone(info, said); });
    TellChannels(actions);
  }
  if (freed) actions.emplace_back(claims_freed_);
}

void SubscriberEndpoint::Tick(SteadyTime now) {
  Actions actions;
  {
    const SocketUse use(mutex_, socket_, input_, *carrier_.waker);
    if (connected_ && !welcomed_ && !plain_mode_ && now - connected_since_ >= carrier_.options.plain_after) {
      plain_mode_ = true;
      for (auto& [name, link] : links_) {
        if (link.allowed) SetPlain(link, true);
      }
    }
    if (unreached_since_ && now - *unreached_since_ >= carrier_.options.unreachable_after) {
      unreached_since_.reset();
      TellUnreachable();
    }
    if (given_up_since_ && now - *given_up_since_ >= kGivenUpAfter) {
      given_up_since_.reset();
      socket_.Disconnect(endpoint_);
      if (const int error = socket_.Connect(endpoint_); error != 0) {
        carrier_.log.Write(LogLevel::kError,
                           "Cannot subscribe at " + endpoint_ + " again: " + zmq_strerror(error) + ".");
      }
    }
    const auto timeout = carrier_.options.peer_timeout;
    if (publisher_ && publisher_->alive && now - publisher_->last_heard > timeout) {
      LosePublisher("it was silent for " + std::to_string(timeout.count()) + " ms", false, actions);
    }
    if (connected_ && publisher_ && welcomed_) {
      auto said = ControlFrom(carrier_.self.info.id);
      publisher_->clock.Ask(*said.mutable_heartbeat(), carrier_.Wall());
      Say(said);
    }
  }
  // From here on the inbox is the place of all calls: they keep their order with what was read before.
  AddActions(actions);
  TellCredits(true);
}

std::optional<SteadyTime> SubscriberEndpoint::Deadline() const {
  const std::scoped_lock lock(mutex_);
  if (unreached_since_) return *unreached_since_ + carrier_.options.unreachable_after;
  if (!connected_ || welcomed_ || plain_mode_) return std::nullopt;
  return connected_since_ + carrier_.options.plain_after;
}

void SubscriberEndpoint::Forgive(SteadyTime now) {
  const std::scoped_lock lock(mutex_);
  if (publisher_) publisher_->last_heard = now;
}

}  // namespace hgros::zmq
