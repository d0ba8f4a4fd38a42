// What subscribing peers say, and what a publisher answers. All on the core's own thread.
#include <algorithm>
#include <utility>

#include "hgros/base/names.hpp"
#include "transport/shm/shm_core.hpp"

namespace hgros::shm {
namespace {

constexpr std::size_t kMaxWishes = kCells;

Demand DemandOf(const wire::Wish& asked, std::uint64_t max_credit_bytes) {
  return PeerChannel::Granted({.lossless = asked.lossless(),
                               .queue_depth = asked.queue_depth(),
                               .credit_messages = asked.credit_messages(),
                               .credit_bytes = asked.credit_bytes()},
                              max_credit_bytes);
}

}  // namespace

void ShmCore::OnWish(Pair& pair, const wire::Wish& asked) {
  const std::string& name = asked.wanted().channel();
  Actions actions;
  Leavings leavings;
  Bells bells;
  {
    const std::scoped_lock lock(mutex_);
    if (!pair.alive) return;
    if (!ChannelNameFault(name).empty() || asked.wanted().type_name().size() > kMaxTypeNameBytes ||
        asked.cell() >= kCells || (pair.wishes.size() >= kMaxWishes && !pair.wishes.contains(name))) {
      Distrust(pair, "it asks for what cannot be");
      return;
    }
    // It has not heard yet that the link has ended.
    if (const auto ended = pair.ended.find(name); ended != pair.ended.end()) {
      if (ended->second == asked.link()) return;
      pair.ended.erase(ended);
    }
    PeerWish& wish = pair.wishes[name];
    const bool change = wish.link && wish.link->link == asked.link();
    wish.asked = asked;
    if (change) {
      OutLink& link = *wish.link;
      const Demand granted = DemandOf(asked, options_.max_credit_bytes);
      if (link.flow.lossless() != granted.lossless) {
        link.core->lossless.fetch_add(granted.lossless ? 1 : static_cast<std::size_t>(-1));
      }
      link.core->dropped.fetch_add(link.flow.SetDemand(granted, leavings.messages), std::memory_order_relaxed);
      SayGranted(pair, link, {});
      Drain(link, leavings, bells);
      OutboundCore::TellRoom(link.core, actions);
    } else {
      RemoveLink(wish, LinkEnd::kForGood, actions);
      Activate(pair, wish, actions);
    }
  }
  for (const auto& bell : bells) bell->Ring();
  for (const auto& action : actions) action();
}

void ShmCore::Activate(Pair& pair, PeerWish& wish, Actions& actions) {
  const auto& wanted = wish.asked.wanted();
  const auto found = channels_.find(wanted.channel());
  if (found == channels_.end()) return;  // Granted when it is offered.
  const auto& core = found->second;
  const auto descriptor_set = SchemaFor(wanted, core->type);
  if (!descriptor_set) {
    const std::string what = DescribeMismatch(wanted, core->type);
    wire::PairMessage said;
    said.mutable_misfit()->set_link(wish.asked.link());
    WriteType(core->name, core->type, *said.mutable_misfit()->mutable_offered());
    said.mutable_misfit()->set_reason(what);
    pair.socket.Send(said);
    actions.emplace_back(
        [this, to = pair.shared_from_this(), channel = core->name, what] { TellMismatch(*to, channel, what); });
    return;
  }
  wish.link = std::make_unique<OutLink>(pair, core, wish.asked.link(), wish.asked.cell(),
                                        DemandOf(wish.asked, options_.max_credit_bytes));
  core->links.push_back(wish.link.get());
  if (wish.link->flow.lossless()) core->lossless.fetch_add(1);
  OutboundCore::CountSubscriber(core, pair.facts.info.id, 1, actions);
  SayGranted(pair, *wish.link, *descriptor_set);
  actions.emplace_back(
      [this, core, to = pair.shared_from_this(), link = wish.link->link] { StartLink(core, *to, link); });
}

void ShmCore::SayGranted(Pair& pair, const OutLink& link, const std::string& descriptor_set) {
  wire::PairMessage said;
  auto& granted = *said.mutable_granted();
  granted.set_link(link.link);
  WriteType(link.core->name, link.core->type, *granted.mutable_offered());
  granted.set_credit_messages(link.flow.demand().credit_messages);
  granted.set_credit_bytes(link.flow.demand().credit_bytes);
  granted.set_descriptor_set(descriptor_set);
  pair.socket.Send(said);
}

void ShmCore::StartLink(const std::shared_ptr<OutChannel>& core, Pair& pair, std::uint64_t link) {
  const SessionId subscriber = pair.facts.info.id;
  std::vector<OutboundMessage> messages;
  std::vector<PendingMessage> latched;
  const bool open = core->gate.Through([&] {
    messages = core->source.Latched(subscriber);
    for (const auto& message : messages) {
      const auto packed = Pack(message.head, message.data);
      latched.push_back({packed, packed->id, packed->data.bytes.size()});
    }
  });
  if (!open) return;
  Leavings leavings;
  leavings.messages = latched;  // Those that are not needed end after the lock.
  Bells bells;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto wish = pair.wishes.find(core->name);
    if (wish == pair.wishes.end() || !wish->second.link || wish->second.link->link != link) {
      // Perhaps it was lost again before it was given any.
      if (!pair.alive && !messages.empty()) (void)KeepForLater(*core, subscriber, {}, std::move(messages));
      return;
    }
    std::erase_if(latched, [&](const PendingMessage& one) {
      return !Accepts(*wish->second.link, static_cast<const ShmMessage&>(*one.packed), actions);
    });
    wish->second.link->flow.Begin(std::move(latched));
    Drain(*wish->second.link, leavings, bells);
  }
  for (const auto& bell : bells) bell->Ring();
  for (const auto& action : actions) action();
}

bool ShmCore::KeepForLater(const OutLink& link) {
  std::vector<OutboundMessage> messages;
  for (const PendingMessage& pending : link.flow.Unfinished()) {
    const auto& message = static_cast<const ShmMessage&>(*pending.packed);
    PacketHead head;
    head.channel = link.core->name;
    head.type_name = link.core->type.name;
    head.encoding = link.core->type.encoding;
    head.fingerprint = link.core->type.fingerprint;
    head.id = message.id;
    head.publish_time_ns = message.publish_time_ns;
    head.publish_monotonic_ns = message.publish_monotonic_ns;
    head.latched = message.latched;
    messages.push_back({std::move(head), message.data});
  }
  return KeepForLater(*link.core, link.pair.facts.info.id, link.flow.demand(), std::move(messages));
}

bool ShmCore::KeepForLater(OutChannel& core, SessionId subscriber, const Demand& demand,
                           std::vector<OutboundMessage>&& messages) {
  bool kept = false;
  core.gate.Through([&] { kept = core.source.OnCut(subscriber, demand, std::move(messages)); });
  return kept;
}

void ShmCore::RemoveLink(PeerWish& wish, LinkEnd why, Actions& actions) {
  if (!wish.link) return;
  const std::shared_ptr<OutLink> link = std::move(wish.link);
  std::erase(link->core->links, link.get());
  link->pair.waiting_bytes -= link->counted_bytes;
  link->core->queued_bytes.fetch_sub(link->counted_bytes, std::memory_order_relaxed);
  if (link->flow.lossless()) {
    const auto ended = std::make_shared<Leavings>();
    ReadCredit(*link, *ended);
    actions.emplace_back([ended] {});
    const bool misses = why == LinkEnd::kForGood || (why == LinkEnd::kPairLost && !KeepForLater(*link));
    if (misses) link->core->missed.fetch_add(link->flow.unfinished(), std::memory_order_relaxed);
    link->core->lossless.fetch_sub(1);
    OutboundCore::TellRoom(link->core, actions);
  }
  OutboundCore::CountSubscriber(link->core, link->pair.facts.info.id, -1, actions);
  actions.emplace_back([link] {});  // Its messages end when no mutex is held: their destructors are the user's code.
}

void ShmCore::OnUnwish(Pair& pair, const wire::Unwish& unwish) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto wish = std::ranges::find_if(
        pair.wishes, [&](const auto& entry) { return entry.second.asked.link() == unwish.link(); });
    if (wish == pair.wishes.end()) return;
    const std::string channel = wish->first;
    const bool linked = wish->second.link != nullptr;
    RemoveLink(wish->second, LinkEnd::kAsked, actions);
    pair.wishes.erase(wish);
    if (linked && !unwish.mismatch().empty()) {
      actions.emplace_back(
          [this, &pair, channel, what = Readable(unwish.mismatch())] { TellMismatch(pair, channel, what); });
    }
  }
  for (const auto& action : actions) action();
}

}  // namespace hgros::shm
