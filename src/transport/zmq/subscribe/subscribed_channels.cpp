#include "transport/zmq/subscribe/subscribed_channels.hpp"

#include <algorithm>
#include <utility>

#include "hgros/internal/codec/packet.hpp"
#include "transport/agreement.hpp"
#include "transport/zmq/control.hpp"

namespace hgros::zmq {

SubscribedChannels::SubscribedChannels(SharedState& shared, PublisherConnection& connection, RemotePublisher& publisher,
                                       const ChannelList& allowed, ClaimsFreed claims_freed)
    : shared_(shared),
      connection_(connection),
      publisher_(publisher),
      claims_freed_(std::move(claims_freed)),
      due_(std::make_shared<DueCredits>(shared.waker)) {
  if (allowed) allowed_.emplace(allowed->begin(), allowed->end());
}

bool SubscribedChannels::IsAllowed(const std::string& channel) const {
  return !allowed_ || allowed_->contains(ListedAs(channel));
}

void SubscribedChannels::Add(const std::shared_ptr<InboundCore>& core) {
  InLink& link = links_[core->name];
  link.core = core;
  link.allowed = IsAllowed(core->name);
  if (!link.allowed) return;
  if (connection_.plain()) SetPlain(link, true);
  Ask(link);
}

void SubscribedChannels::Remove(const std::shared_ptr<InboundCore>& core) {
  InLink* link = Find(core->name);
  if (link == nullptr || link->core != core) return;
  Actions unheard;  // Dropped: the channel's sink is ending and gets no more calls.
  StopAsking(*link, {}, unheard);
  links_.erase(core->name);
}

void SubscribedChannels::UpdateDemand(const InboundCore& core) {
  InLink* link = Find(core.name);
  if (link == nullptr || link->core.get() != &core) return;
  link->SetPlainWindow();
  if (link->asked) SendSubscribe(*link, true);
}

void SubscribedChannels::SetAllowed(const ChannelList& allowed, Actions& actions) {
  allowed_.reset();
  if (allowed) allowed_.emplace(allowed->begin(), allowed->end());
  for (auto& [name, link] : links_) {
    const bool now = IsAllowed(name);
    if (std::exchange(link.allowed, now) == now) continue;
    if (now) {
      if (connection_.plain()) SetPlain(link, true);
      Ask(link);
    } else {
      StopAsking(link, {}, actions);
    }
  }
}

void SubscribedChannels::SetPlain(bool plain) {
  for (auto& [name, link] : links_) {
    if (!plain || link.allowed) SetPlain(link, plain);
  }
}

void SubscribedChannels::SetPlain(InLink& link, bool plain) {
  if (link.plain == plain) return;
  link.plain = plain;
  // One account for all connections: messages of an earlier connection are still in flight.
  if (plain && !link.plain_credit) link.plain_credit = std::make_shared<LinkCredit>(0, 0, link.core->name, nullptr);
  link.SetPlainWindow();
  connection_.SubscribeTopic(link.core->plain_topic, plain);
}

void SubscribedChannels::AskForAll() {
  for (auto& [name, link] : links_) {
    SetAsked(link, false);
    Ask(link);
  }
}

void SubscribedChannels::AskAgain(const InboundCore* core, Actions& actions) {
  if (core == nullptr) {
    for (auto& [name, link] : links_) AskAgain(link, actions);
  } else if (InLink* const link = Find(core->name)) {
    AskAgain(*link, actions);
  }
}

void SubscribedChannels::AskAgain(InLink& link, Actions& actions) {
  const auto& takes = shared_.options.takes;
  if (link.asked && publisher_.known() && takes && !takes(publisher_.id(), link.core->name)) {
    StopAsking(link, {}, actions);
  } else {
    Ask(link);
  }
}

void SubscribedChannels::DropAll(Actions& actions) {
  for (auto& [name, link] : links_) {
    if (link.asked) StopAsking(link, {}, actions);
  }
}

void SubscribedChannels::Ask(InLink& link) {
  if (!publisher_.alive || !link.allowed || link.asked) return;
  if (shared_.options.takes && !shared_.options.takes(publisher_.id(), link.core->name)) return;
  if (asked_ >= kMaxChannels) {
    LogTooManyChannels(shared_.log, publisher_.facts.info, link.core->name, "ZeroMQ");
    return;
  }
  // Keeps the claim until an answer says that the channel is not available here.
  if (!link.core->Claim(publisher_.id(), this, publisher_.handshake)) return;
  if (!link.subscribed) {
    link.subscribed = true;
    connection_.SubscribeTopic(PeerTopic(link.core->name, shared_.self.info.id), true);
  }
  SetAsked(link, true);
  SendSubscribe(link, false);
}

void SubscribedChannels::SetAsked(InLink& link, bool asked) {
  if (std::exchange(link.asked, asked) == asked) return;
  asked_ += asked ? 1 : std::size_t(-1);
}

void SubscribedChannels::SendSubscribe(InLink& link, bool change_only) {
  const Demand demand = link.core->demand();
  link.asked_messages = std::max<std::uint64_t>(link.asked_messages, demand.credit_messages);
  link.asked_bytes = std::max(link.asked_bytes, demand.credit_bytes);
  auto message = ControlFrom(shared_.self.info.id);
  auto& subscribe = *message.mutable_subscribe();
  WriteType(link.core->name, link.core->type, *subscribe.mutable_wanted());
  subscribe.set_handshake(publisher_.handshake);
  subscribe.set_lossless(demand.lossless);
  subscribe.set_queue_depth(demand.queue_depth);
  subscribe.set_credit_messages(demand.credit_messages);
  subscribe.set_credit_bytes(demand.credit_bytes);
  subscribe.set_change_only(change_only);
  if (!change_only) {
    link.wish = RandomId();
    link.certain = false;
  }
  subscribe.set_wish(link.wish);
  if (link.id != 0) {
    subscribe.set_link(link.id);
    subscribe.set_received_messages(link.credit->received());
    subscribe.set_received_bytes(link.credit->received_bytes());
  }
  connection_.Send(message);
}

void SubscribedChannels::SendUnsubscribe(const std::string& channel, std::string_view mismatch) {
  auto message = ControlFrom(shared_.self.info.id);
  message.mutable_unsubscribe()->set_channel(channel);
  message.mutable_unsubscribe()->set_mismatch(std::string(mismatch.substr(0, kMaxTextBytes)));
  connection_.Send(message);
}

void SubscribedChannels::OnSubscribed(const wire::Subscribed& subscribed, Actions& actions) {
  const std::string& name = subscribed.offered().channel();
  if (subscribed.link() == 0) return;
  InLink* link = Find(name);
  if (link != nullptr && IsClaimedBeside(*link)) {
    // The answer is for another endpoint that leads to the same socket. The channel may have been asked for here
    // before it was withdrawn.
    if (link->subscribed) connection_.SubscribeTopic(PeerTopic(name, shared_.self.info.id), false);
    link->subscribed = false;
    SetAsked(*link, false);
    return;
  }
  if (link == nullptr || !link->asked) {
    // The publisher answers a wish from before a cut, or one that we have ended since. An unread link would use up
    // its credit.
    SendUnsubscribe(name, {});
    return;
  }
  if (!link->core->Claim(publisher_.id(), this, publisher_.handshake)) {
    // The channel was withdrawn here, or not offered yet, and comes over another endpoint by now.
    StopAsking(*link, {}, actions);
    return;
  }
  if (link->id == subscribed.link()) {
    link->SetWindow(subscribed);
    // It was told that the offer ended when the publisher was lost.
    if (!link->active && link->schema) {
      InboundCore::TellOffer(link->core, publisher_.facts.info, link->schema, actions);
    }
  } else {
    // The publisher had lost this session, which has not noticed it.
    if (std::exchange(link->active, false)) InboundCore::CountPublisher(link->core, publisher_.id(), -1, actions);
    if (!BeginLink(*link, subscribed, actions)) return;
  }
  if (!std::exchange(link->active, true)) InboundCore::CountPublisher(link->core, publisher_.id(), 1, actions);
  link->certain = subscribed.wish() == link->wish;
}

bool SubscribedChannels::BeginLink(InLink& link, const wire::Subscribed& subscribed, Actions& actions) {
  const std::string& name = link.core->name;
  const TypeInfo& type = link.core->type;
  bool fits = true;
  std::string fault;
  switch (CompareTypes(subscribed.offered(), type)) {
    case TypeFit::kEqual: break;
    case TypeFit::kEvolved:
      fault = SchemaFault(subscribed.descriptor_set(), type);
      fits = fault.empty();
      if (fits) {
        shared_.log.WriteLimited(LogLevel::kDebug, "evolved " + name,
                                 "Channel " + name + ": " + publisher_.facts.info.process +
                                     " publishes another, compatible version of " + type.name + ".");
      }
      break;
    case TypeFit::kDiffer: fits = false; break;
  }
  if (!fits) {
    const std::string what =
        DescribeMismatch(subscribed.offered(), publisher_.facts.info, type, shared_.self.info, true) +
        (fault.empty() ? "" : ": " + fault);
    StopAsking(link, what, actions);
    SetAsked(link, true);  // And refused: it is not asked for again before the next Welcome.
    ReportMismatch(name, what, actions);
    return false;
  }
  link.Begin(subscribed, due_);
  link.schema = nullptr;
  if (IsAnyType(type) || !subscribed.descriptor_set().empty()) {
    link.schema = ReadSchema(subscribed.offered(), subscribed.descriptor_set(), publisher_.facts.info, shared_.log);
    InboundCore::TellOffer(link.core, publisher_.facts.info, link.schema, actions);
  }
  return true;
}

void SubscribedChannels::OnRefused(const wire::Refused& refused, Actions& actions) {
  InLink* link = Find(refused.offered().channel());
  if (link == nullptr || !link->asked) return;
  EndLink(*link, actions);
  ReleaseClaim(*link, actions);
  ReportMismatch(link->core->name,
                 DescribeMismatch(refused.offered(), publisher_.facts.info, link->core->type, shared_.self.info, true),
                 actions);
}

void SubscribedChannels::OnWithdrawn(const std::string& channel, Actions& actions) {
  InLink* link = Find(channel);
  if (link == nullptr) return;
  EndLink(*link, actions, OfferEnd::kWithdrawn);
  ReleaseClaim(*link, actions);
}

bool SubscribedChannels::IsClaimedBeside(const InLink& link) const {
  return publisher_.known() && link.core->IsClaimedBeside(publisher_.id(), this, publisher_.handshake);
}

void SubscribedChannels::ReleaseClaim(const InLink& link, Actions& actions) {
  if (!publisher_.known() || !link.core->Release(publisher_.id(), this)) return;
  actions.emplace_back([freed = claims_freed_, core = link.core] { freed(core.get()); });
}

void SubscribedChannels::ReportMismatch(const std::string& channel, const std::string& what, Actions& actions) {
  if (!publisher_.reported_mismatches.insert(channel).second) return;
  actions.emplace_back(
      [this, info = publisher_.facts.info, channel, what] { shared_.listener.OnTypeMismatch(channel, info, what); });
}

void SubscribedChannels::EndLink(InLink& link, Actions& actions, OfferEnd why) {
  link.End();
  if (std::exchange(link.active, false)) InboundCore::CountPublisher(link.core, publisher_.id(), -1, actions, why);
}

void SubscribedChannels::StopAsking(InLink& link, std::string_view mismatch, Actions& actions) {
  const bool tells = !shared_.leaving;
  if (tells) SetPlain(link, false);
  if (std::exchange(link.subscribed, false) && tells) {
    connection_.SubscribeTopic(PeerTopic(link.core->name, shared_.self.info.id), false);
  }
  if (tells && link.asked && publisher_.alive && !IsClaimedBeside(link)) SendUnsubscribe(link.core->name, mismatch);
  SetAsked(link, false);
  ReleaseClaim(link, actions);
  EndLink(link, actions);
}

bool SubscribedChannels::OnPublisherLost(bool for_good, Actions& actions) {
  bool freed = false;
  for (auto& [name, link] : links_) {
    freed = link.core->Release(publisher_.id(), this) || freed;
    SetAsked(link, false);
    if (for_good) {
      EndLink(link, actions);
    } else if (std::exchange(link.active, false)) {
      InboundCore::CountPublisher(link.core, publisher_.id(), -1, actions);
    }
  }
  return freed;
}

void SubscribedChannels::SendCredit(bool all) {
  while (const auto credit = due_->Take()) {
    credit->OnTaken();
    InLink* const link = Find(credit->channel());
    if (link != nullptr && link->credit == credit) SendCredit(*link);
  }
  if (!all) return;
  for (auto& [name, link] : links_) {
    if (link.id != 0) SendCredit(link);
  }
}

void SubscribedChannels::SendCredit(InLink& link) {
  LinkCredit::Totals consumed;
  if (!link.credit->CollectNews(consumed)) return;
  auto message = ControlFrom(shared_.self.info.id);
  auto& credit = *message.mutable_credit();
  credit.set_channel(link.core->name);
  credit.set_link(link.id);
  credit.set_consumed_messages(consumed.messages);
  credit.set_consumed_bytes(consumed.bytes);
  connection_.Send(message);
}

}  // namespace hgros::zmq
