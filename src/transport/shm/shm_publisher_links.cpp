// The begin and the end of links and pairs, on the publisher's side.
#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

#include "transport/shm/shm_publisher.hpp"

namespace hgros::shm {
namespace {

// Null if there is none.
OutLink* FindLink(const OutChannel& core, const Pair& pair) {
  const auto found = pair.out.links.find(&core);
  return found == pair.out.links.end() ? nullptr : found->second.get();
}

// False if the source does not keep them.
bool KeepForLater(OutChannel& core, SessionId subscriber, const Demand& demand,
                  std::vector<OutboundMessage>&& messages) {
  bool kept = false;
  core.gate.Through([&] { kept = core.source.OnCut(subscriber, demand, std::move(messages)); });
  return kept;
}

// Passes the messages that the subscriber has not confirmed to the source.
bool KeepForLater(const OutLink& link) {
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

}  // namespace

void ShmPublisher::AddLink(const std::shared_ptr<OutChannel>& core, Pair& pair, const wire::Wish& asked,
                           const Demand& granted, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  const auto link = std::make_shared<OutLink>(pair, core, asked.link(), asked.cell(), granted);
  pair.out.links.emplace(core.get(), link);
  core->links.push_back(link.get());
  if (link->flow.lossless()) core->lossless.fetch_add(1);
  OutboundCore::CountSubscriber(core, pair.facts.info.id, 1, actions);
}

void ShmPublisher::BeginLink(const std::shared_ptr<OutChannel>& core, Pair& pair, std::uint64_t number) {
  const SessionId subscriber = pair.facts.info.id;
  std::vector<OutboundMessage> messages;
  std::vector<PendingMessage> latched;
  const bool open = core->gate.Through([&] {
    messages = core->source.Latched(subscriber);
    for (const auto& message : messages) {
      try {
        const auto packed = packer_.Pack(message.head, message.data);
        latched.push_back({packed, packed->id, packed->data.bytes.size()});
      } catch (const std::bad_alloc&) {
        core->missed.fetch_add(1, std::memory_order_relaxed);
      }
    }
  });
  if (!open) return;
  Leavings leavings;
  leavings.messages = latched;  // Messages that are not needed end after the lock.
  Bells bells;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    OutLink* const link = FindLink(*core, pair);
    if (link == nullptr || link->link != number) {
      // The pair may have been lost before the link got any.
      if (!pair.alive && !messages.empty()) (void)KeepForLater(*core, subscriber, {}, std::move(messages));
      return;
    }
    std::erase_if(latched, [&](const PendingMessage& one) {
      return RefuseIfTooLarge(*link, static_cast<const ShmMessage&>(*one.packed), actions);
    });
    link->flow.Begin(std::move(latched));
    Drain(*link, leavings, bells);
  }
  for (const auto& bell : bells) bell->Ring();
  for (const auto& action : actions) action();
}

void ShmPublisher::ChangeDemand(const OutChannel& core, Pair& pair, const Demand& granted,
                                const wire::PairMessage& answer, Actions& actions) {
  const auto dropped = std::make_shared<Leavings>();
  actions.emplace_back([dropped] {});  // Destroyed when no mutex is held.
  Bells bells;
  const std::scoped_lock lock(mutex_);
  OutLink* const link = FindLink(core, pair);
  if (link == nullptr) return;
  if (link->flow.lossless() != granted.lossless) {
    link->core->lossless.fetch_add(granted.lossless ? 1 : static_cast<std::size_t>(-1));
  }
  link->core->dropped.fetch_add(link->flow.SetDemand(granted, dropped->messages), std::memory_order_relaxed);
  pair.socket.Send(answer);
  Drain(*link, *dropped, bells);
  for (auto& bell : bells) actions.emplace_back([bell = std::move(bell)] { bell->Ring(); });
  OutboundCore::TellRoom(link->core, actions);
}

void ShmPublisher::RemoveLink(const OutChannel& core, Pair& pair, LinkEnd why, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  if (auto node = pair.out.links.extract(&core)) EndLink(std::move(node.mapped()), why, actions);
}

void ShmPublisher::WithdrawLink(const OutChannel& core, Pair& pair, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  auto node = pair.out.links.extract(&core);
  if (!node) return;
  wire::PairMessage said;
  said.mutable_ended()->set_link(node.mapped()->link);
  said.mutable_ended()->set_messages(node.mapped()->flow.sent());
  pair.socket.Send(said);
  EndLink(std::move(node.mapped()), LinkEnd::kWithdrawn, actions);
}

void ShmPublisher::RemoveAllLinks(Pair& pair, LinkEnd why, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  for (auto& [core, link] : std::exchange(pair.out.links, {})) EndLink(link, why, actions);
}

void ShmPublisher::EndLink(std::shared_ptr<OutLink> link, LinkEnd why, Actions& actions) {
  std::erase(link->core->links, link.get());
  link->pair.out.waiting_bytes -= link->counted_bytes;
  link->core->queued_bytes.fetch_sub(link->counted_bytes, std::memory_order_relaxed);
  if (link->flow.lossless()) {
    const auto ended = std::make_shared<Leavings>();
    ReadCredit(*link, *ended);
    actions.emplace_back([ended] {});
    const bool misses =
        why == LinkEnd::kForGood || why == LinkEnd::kWithdrawn || (why == LinkEnd::kPairLost && !KeepForLater(*link));
    if (misses && why == LinkEnd::kWithdrawn) {
      link->core->missed.fetch_add(link->flow.unfinished(), std::memory_order_relaxed);
    } else if (misses) {
      const PeerInfo& peer = link->pair.facts.info;
      const std::string who = "Session " + peer.name();
      OutboundCore::TellMissed(link->core, session_.log, peer.id, who, link->flow.unfinished(), actions);
    }
    link->core->lossless.fetch_sub(1);
    OutboundCore::TellRoom(link->core, actions);
  }
  if (why == LinkEnd::kAsked) OutboundCore::TellUnsubscribed(link->core, link->pair.facts.info.id, actions);
  OutboundCore::CountSubscriber(link->core, link->pair.facts.info.id, -1, actions);
  // Its messages are destroyed when no mutex is held: their destructors are the user's code.
  actions.emplace_back([link = std::move(link)] {});
}

bool ShmPublisher::OpenPair(Pair& pair, const Handle& slip, std::shared_ptr<const PeerBell> bell,
                            std::uint64_t max_message_bytes, std::string& fault) {
  const std::scoped_lock lock(mutex_);
  if (!pair.out.lane->Open(slip, fault)) return false;
  pair.out.bell = std::move(bell);
  pair.out.max_message_bytes = max_message_bytes;
  return true;
}

void ShmPublisher::ResendApart(Pair& pair, std::uint32_t segment) {
  constexpr int kMostPauses = 64;  // Heartbeats.
  Leavings leavings;
  const std::scoped_lock lock(mutex_);
  const auto told = pair.out.told_segments.find(segment);
  if (!pair.out.lane || told == pair.out.told_segments.end() || told->second.refused) return;
  const auto heartbeat = session_.options.heartbeat;
  told->second.refused = true;
  told->second.pause = std::clamp(2 * told->second.pause, heartbeat, kMostPauses * heartbeat);
  told->second.next_try = std::chrono::steady_clock::now() + told->second.pause;
  Collect(pair, leavings);
  for (const LaneWriter::Held& held : pair.out.lane->TakeHeldIn(segment)) {
    const auto* packed = static_cast<const Outgoing*>(held.owner.get());
    pair.socket.SendPayload(held.descriptor.link, held.descriptor.number, static_cast<const ShmMessage*>(packed)->data);
    sent_apart_.fetch_add(1, std::memory_order_relaxed);
  }
  sockets_.FlushSoon(pair);
}

std::uint32_t ShmPublisher::Beat(Pair& pair, const std::vector<std::uint32_t>& removed) {
  Leavings leavings;
  const auto now = std::chrono::steady_clock::now();
  const std::scoped_lock lock(mutex_);
  pair.out.lane->Beat();
  Collect(pair, leavings);
  for (auto& [core, link] : pair.out.links) {
    ReadCredit(*link, leavings);
    ReportTooLarge(*link);
    if (link->flow.HoldsUp(core->refused, now)) core->SayHeldUp(session_.log, NameOf(pair));
  }
  for (const std::uint32_t segment : removed) {
    if (pair.out.told_segments.erase(segment) == 0) continue;
    wire::PairMessage said;
    said.mutable_segment_removed()->set_segment(segment);
    pair.socket.Send(said);
  }
  return pair.out.lane->peer_heartbeat();
}

std::unique_ptr<LaneWriter> ShmPublisher::ReleaseLane(Pair& pair) {
  const std::scoped_lock lock(mutex_);
  return std::move(pair.out.lane);
}

bool ShmPublisher::Close(int linger_ms) noexcept {
  if (closing_.exchange(true)) return false;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(linger_ms);
  std::unique_lock lock(sent_mutex_);
  while (!AllSent()) {
    const auto seen = rounds_;
    if (!sent_.wait_until(lock, deadline, [&] { return rounds_ != seen; })) break;
  }
  return true;
}

bool ShmPublisher::AllSent() {
  const auto pairs = pairs_.List();
  const std::scoped_lock lock(mutex_);
  return std::ranges::all_of(pairs, [](const auto& pair) {
    return !pair->alive ||
           (pair->out.waiting_bytes == 0 && pair->socket.all_sent() &&
            std::ranges::all_of(pair->out.links, [](const auto& entry) { return entry.second->flow.waiting() == 0; }));
  });
}

void ShmPublisher::NotifyClose() {
  if (!closing_.load()) return;
  const std::scoped_lock lock(sent_mutex_);
  ++rounds_;
  sent_.notify_all();
}

}  // namespace hgros::shm
