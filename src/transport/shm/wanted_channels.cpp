#include "transport/shm/wanted_channels.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::shm {

void WantedChannels::Want(const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(mutex_);
  if (!channels_.emplace(core->name, core).second) {
    throw Error("Channel " + core->name + " is already subscribed to here.", {},
                "Share the first object, or destroy it first.");
  }
  for (const auto& pair : pairs_.List()) {
    if (pair->asks && MayAsk(*pair, core->name)) Ask(*pair, core);
  }
}

void WantedChannels::Unwant(const std::shared_ptr<InboundCore>& core) {
  Actions nobody_listens;  // Destroyed after the lock.
  const std::scoped_lock lock(mutex_);
  const auto found = channels_.find(core->name);
  if (found == channels_.end() || found->second != core) return;
  channels_.erase(found);
  for (const auto& pair : pairs_.List()) RemoveLink(*pair, core->name, {}, nobody_listens);
}

void WantedChannels::ChangeDemand(const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(mutex_);
  for (const auto& pair : pairs_.List()) {
    if (const auto link = pair->in.LinkOf(core->name)) SendWish(*pair, *link);
  }
}

void WantedChannels::AskPair(Pair& pair) {
  const std::scoped_lock lock(mutex_);
  AskForAll(pair);
}

void WantedChannels::AskPairs() {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& pair : pairs_.List()) {
      if (!pair->alive) continue;
      for (const auto& [name, core] : channels_) {
        if (pair->in.LinkOf(name) && !MayAsk(*pair, name)) RemoveLink(*pair, name, {}, actions);
      }
      AskForAll(*pair);
    }
  }
  for (const auto& action : actions) action();
}

bool WantedChannels::Asks(const InboundCore& core, SessionId publisher) const {
  const std::scoped_lock lock(mutex_);
  return std::ranges::any_of(pairs_.List(), [&](const auto& pair) {
    return pair->alive && pair->facts.info.id == publisher && pair->in.LinkOf(core.name);
  });
}

void WantedChannels::StopAsking(Pair& pair) {
  const std::scoped_lock lock(mutex_);
  pair.asks = false;
}

void WantedChannels::AskForAll(Pair& pair) {
  pair.asks = true;
  for (const auto& [name, core] : channels_) {
    if (!pair.in.LinkOf(name) && MayAsk(pair, name)) Ask(pair, core);
  }
}

bool WantedChannels::MayAsk(const Pair& pair, const std::string& channel) const {
  const auto& takes = session_.options.takes;
  return !takes || takes(pair.facts.info.id, channel);
}

void WantedChannels::Ask(Pair& pair, const std::shared_ptr<InboundCore>& core) {
  if (const auto link = pair.in.AddLink(core)) {
    SendWish(pair, *link);
    return;
  }
  LogTooManyChannels(session_.log, pair.facts.info, core->name, "shared memory");
}

void WantedChannels::SendWish(Pair& pair, InLink& link) {
  const Demand demand = link.core->demand();
  pair.in.RaiseLimits(link, demand);
  wire::PairMessage said;
  auto& wish = *said.mutable_wish();
  wish.set_link(link.link);
  WriteType(link.core->name, link.core->type, *wish.mutable_wanted());
  wish.set_cell(link.receipt->cell());
  wish.set_lossless(demand.lossless);
  wish.set_queue_depth(demand.queue_depth);
  wish.set_credit_messages(demand.credit_messages);
  wish.set_credit_bytes(demand.credit_bytes);
  pair.socket.Send(said);
}

// `mismatch`: why the types do not fit; empty if the subscription ends for another reason.
void WantedChannels::RemoveLink(Pair& pair, const std::string& channel, std::string_view mismatch, Actions& actions,
                                OfferEnd why) {
  const auto link = pair.in.RemoveLink(channel);
  if (!link) return;
  wire::PairMessage said;
  said.mutable_unwish()->set_link(link->link);
  said.mutable_unwish()->set_mismatch(mismatch.data(), std::min(mismatch.size(), kMaxTextBytes));
  pair.socket.Send(said);
  if (link->granted) InboundCore::CountPublisher(link->core, pair.facts.info.id, -1, actions, why);
}

void WantedChannels::OnGranted(Pair& pair, const wire::Granted& granted) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto link = pair.in.LinkAt(granted.link());
    if (!link) return;
    const TypeInfo& type = link->core->type;
    bool fits = true;
    std::string fault;
    if (!link->granted) {
      switch (CompareTypes(granted.offered(), type)) {
        case TypeFit::kEqual: break;
        case TypeFit::kEvolved:
          fault = SchemaFault(granted.descriptor_set(), type);
          fits = fault.empty();
          if (!fits) break;
          session_.log.WriteLimited(LogLevel::kDebug, "evolved " + link->core->name,
                                    "Channel " + link->core->name + ": " + pair.facts.info.process +
                                        " publishes another, compatible version of " + type.name + ".");
          break;
        case TypeFit::kDiffer: fits = false; break;
      }
    }
    if (!fits) {
      const std::string what = DescribeMismatch(granted.offered(), pair.facts.info, type, session_.self.info, true) +
                               (fault.empty() ? "" : ": " + fault);
      RemoveLink(pair, link->core->name, what, actions);
      actions.emplace_back(
          [this, &pair, channel = link->core->name, what] { ReportMismatch(session_.listener, pair, channel, what); });
    } else {
      std::shared_ptr<const MessageSchema> schema;
      if (!link->granted && (IsAnyType(type) || !granted.descriptor_set().empty())) {
        schema = ReadSchema(granted.offered(), granted.descriptor_set(), pair.facts.info, session_.log);
        InboundCore::TellOffer(link->core, pair.facts.info, schema, actions);
      }
      if (pair.in.Grant(*link, granted, std::move(schema))) {
        InboundCore::CountPublisher(link->core, pair.facts.info.id, 1, actions);
      }
    }
  }
  for (const auto& action : actions) action();
}

void WantedChannels::OnMisfit(Pair& pair, const wire::Misfit& misfit) {
  const auto link = pair.in.LinkAt(misfit.link());
  if (!link || link->granted) return;
  ReportMismatch(session_.listener, pair, link->core->name,
                 DescribeMismatch(misfit.offered(), pair.facts.info, link->core->type, session_.self.info, true));
}

void WantedChannels::OnEnded(Pair& pair, const wire::Ended& ended) {
  if (pair.in.EndAfter(ended.link(), ended.messages())) EndLink(pair, ended.link());
}

void WantedChannels::EndLink(Pair& pair, std::uint64_t number) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto link = pair.in.LinkAt(number);
    if (!link) return;
    const auto core = link->core;
    RemoveLink(pair, core->name, {}, actions, OfferEnd::kWithdrawn);
    const auto wanted = channels_.find(core->name);
    const bool still = wanted != channels_.end() && wanted->second == core;
    if (pair.asks && still && MayAsk(pair, core->name)) Ask(pair, core);
  }
  for (const auto& action : actions) action();
}

// Each message counts as one fault; those that the peer reports together are logged once.
bool WantedChannels::OnTooLarge(Pair& pair, const wire::TooLarge& said) {
  constexpr std::uint64_t kMostAtOnce = 1u << 16;
  const auto link = pair.in.LinkAt(said.link());
  if (!link || said.messages() <= link->too_large) return true;
  const std::uint64_t more = said.messages() - link->too_large;
  if (more > kMostAtOnce || said.bytes() <= session_.options.max_message_bytes) return false;
  link->too_large = said.messages();
  session_.CountFault(PacketFault::kOverrun, more);
  link->core->TellFault(PacketFault::kOverrun, "it has " + std::to_string(said.bytes()) + " bytes, and " +
                                                   NameOf(pair) + " may send at most " +
                                                   std::to_string(session_.options.max_message_bytes));
  return true;
}

}  // namespace hgros::shm
