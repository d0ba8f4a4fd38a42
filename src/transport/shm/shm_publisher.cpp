#include "transport/shm/shm_publisher.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace hgros::shm {
namespace {

// Whether every lossless subscriber has room for one more message.
bool HasRoom(const OutChannel& channel) {
  return std::ranges::all_of(channel.links,
                             [](const OutLink* link) { return !link->flow.lossless() || link->flow.HasRoom(); });
}

// Corrects the sums of waiting bytes.
void CountWaiting(OutLink& link) {
  const std::uint64_t now = link.flow.waiting_bytes();
  link.pair.out.waiting_bytes += now - link.counted_bytes;  // May wrap around; the sum is right.
  link.core->queued_bytes.fetch_add(now - link.counted_bytes, std::memory_order_relaxed);
  link.counted_bytes = now;
}

}  // namespace

// Checks the known counts, then the peers' current counts, and the current counts again after asking the peers to
// ring.
bool ShmPublisher::FindRoom(const OutChannel& channel, Leavings& leavings) {
  if (HasRoom(channel)) return true;
  for (const bool asked : {false, true}) {
    for (OutLink* link : channel.links) {
      if (!link->flow.lossless()) continue;
      if (asked) {
        link->pair.hungry = true;
        link->pair.out.lane->SetHungry(link->pair.out.lane->hungry() | kForCredit);
      }
      ReadCredit(*link, leavings);
    }
    if (HasRoom(channel)) return true;
  }
  return false;
}

PublishStatus ShmPublisher::Reserve(OutChannel& channel) {
  if (closing_.load(std::memory_order_relaxed)) return PublishStatus::kClosed;
  if (channel.lossless.load() == 0) return PublishStatus::kOk;
  Leavings leavings;
  const std::scoped_lock lock(mutex_);
  if (!HasRoom(channel)) {
    const bool before = channel.refused.exchange(true);  // Before the question: the answer may come at once.
    if (!FindRoom(channel, leavings)) return PublishStatus::kFull;
    channel.refused = before;
  }
  for (OutLink* link : channel.links) {
    if (link->flow.lossless()) link->flow.Reserve();
  }
  return PublishStatus::kOk;
}

std::size_t ShmPublisher::Unfinished(const OutChannel& channel) {
  Leavings leavings;
  const std::scoped_lock lock(mutex_);
  std::size_t unfinished = 0;
  for (OutLink* link : channel.links) {
    if (!link->flow.lossless()) continue;
    ReadCredit(*link, leavings);
    unfinished += link->flow.unfinished();
  }
  return unfinished;
}

void ShmPublisher::Cancel(const std::shared_ptr<OutChannel>& core) {
  if (core->lossless.load() == 0) return;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    for (OutLink* link : core->links) link->flow.CancelReservation();
    if (HasRoom(*core)) OutboundCore::TellRoom(core, actions);
  }
  sockets_.Post(std::move(actions));
}

void ShmPublisher::Commit(const std::shared_ptr<OutChannel>& core, const PacketHead& head, const Payload& data) {
  if (closing_.load(std::memory_order_relaxed) || core->subscribers.load(std::memory_order_relaxed) == 0) return;
  core->NoteCommit(session_.log, head.id.sequence);
  const auto message = packer_.Pack(head, data);
  if (!data.bytes.empty() && (!message->place || message->data.bytes.data() != data.bytes.data())) {
    core->copied.fetch_add(1, std::memory_order_relaxed);
  }
  Leavings leavings;
  Bells bells;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    bool skipped = false;
    for (OutLink* link : core->links) {
      if (RefuseIfTooLarge(*link, *message, actions)) {
        link->flow.CancelReservation();
        skipped = true;
        continue;
      }
      skipped = !link->flow.Push({message, message->id, message->data.bytes.size()}) || skipped;
      if (Send(*link, leavings)) bells.push_back(link->pair.out.bell);
    }
    // This has freed a reservation, and a publish call may have been refused meanwhile.
    if (skipped && HasRoom(*core)) OutboundCore::TellRoom(core, actions);
  }
  // The rest is done after this, because the receivers are already awake.
  for (const auto& bell : bells) bell->Ring();
  bells.clear();
  {
    const std::scoped_lock lock(mutex_);
    for (OutLink* link : core->links) Drain(*link, leavings, bells);
  }
  for (const auto& bell : bells) bell->Ring();
  sockets_.Post(std::move(actions));
}

// A message larger than the peer accepts is not sent. Both sides count it, and the first one is logged.
bool ShmPublisher::RefuseIfTooLarge(OutLink& link, const ShmMessage& message, Actions& actions) {
  const std::uint64_t size = message.data.bytes.size();
  const std::uint64_t limit = link.pair.out.max_message_bytes;
  if (size <= limit) return false;
  (link.flow.lossless() ? link.core->missed : link.core->dropped).fetch_add(1, std::memory_order_relaxed);
  if (link.too_large++ == 0) {
    actions.emplace_back([this, to = link.pair.shared_from_this(), channel = link.core->name, size, limit] {
      session_.log.WriteLimited(LogLevel::kWarning, "shm large " + channel,
                                "A message of " + std::to_string(size) + " bytes on channel \"" + channel +
                                    "\" is not sent to " + NameOf(*to) + ", which accepts at most " +
                                    std::to_string(limit) +
                                    " bytes. Publish smaller messages, or raise the limit there.");
    });
  }
  link.too_large_bytes = size;
  ReportTooLarge(link);
  return true;
}

// While the peer does not read its socket, reports wait and become one frame.
void ShmPublisher::ReportTooLarge(OutLink& link) {
  if (link.told_too_large == link.too_large || !link.pair.socket.all_sent()) return;
  link.told_too_large = link.too_large;
  wire::PairMessage said;
  said.mutable_too_large()->set_link(link.link);
  said.mutable_too_large()->set_messages(link.too_large);
  said.mutable_too_large()->set_bytes(link.too_large_bytes);
  link.pair.socket.Send(said);
}

void ShmPublisher::ReadCredit(OutLink& link, Leavings& leavings) {
  const auto consumed = link.pair.out.lane->ConsumedOf(link.cell);
  if (link.flow.Confirm(consumed.messages, consumed.bytes, leavings.messages)) return;
  sockets_.Distrust(link.pair, "it says that it has consumed more than was sent");
}

void ShmPublisher::Collect(Pair& pair, Leavings& leavings) {
  if (pair.out.lane->Collect(leavings.owners)) return;
  sockets_.Distrust(pair, "it returns a slot that it does not hold");
}

bool ShmPublisher::Send(OutLink& link, Leavings& leavings) {
  bool any = false;
  while (link.pair.out.lane->HasSlot()) {
    auto message = link.flow.Pop();
    if (!message) break;
    if (!Write(link, *message)) leavings.messages.push_back(std::move(*message));
    any = true;
  }
  return any;
}

void ShmPublisher::Drain(OutLink& link, Leavings& leavings, Bells& bells) {
  Pair& pair = link.pair;
  bool sent = Send(link, leavings);
  Collect(pair, leavings);
  if (link.flow.lossless() || link.flow.waiting() > 0) ReadCredit(link, leavings);
  if (link.flow.waiting() > 0) {
    sent = Send(link, leavings) || sent;
    // Try again after each question: for slots and credit that the peer returned before it saw the question, it does
    // not ring.
    for (std::uint32_t asked = 0; link.flow.waiting() > 0;) {
      const std::uint32_t missing = kForCredit | (pair.out.lane->HasSlot() ? 0 : kForSlots);
      if ((asked & missing) == missing) break;
      asked |= missing;
      pair.hungry = true;
      pair.out.lane->SetHungry(pair.out.lane->hungry() | missing);
      Collect(pair, leavings);
      ReadCredit(link, leavings);
      sent = Send(link, leavings) || sent;
    }
  }
  if (sent) bells.push_back(pair.out.bell);
  const std::uint64_t others = pair.out.waiting_bytes - link.counted_bytes;
  const std::uint64_t limit = session_.options.peer_queue_bytes;
  if (const auto count = link.flow.Trim(limit > others ? limit - others : 0, leavings.messages); count > 0) {
    link.core->dropped.fetch_add(count, std::memory_order_relaxed);
  }
  CountWaiting(link);
}

// Sends the segment first, if the peer does not have it.
bool ShmPublisher::MayUse(Pair& pair, std::uint32_t segment) {
  const auto [told, is_new] = pair.out.told_segments.try_emplace(segment);
  if (!is_new && !told->second.refused) return true;
  if (!is_new && std::chrono::steady_clock::now() < told->second.next_try) return false;
  told->second.refused = false;
  wire::PairMessage said;
  said.mutable_segment_added()->set_segment(segment);
  pair.socket.Send(said, {packer_.pool().HandleOf(segment)});
  return true;
}

bool ShmPublisher::Write(OutLink& link, const PendingMessage& queued) {
  const auto& message = static_cast<const ShmMessage&>(*queued.packed);
  Pair& pair = link.pair;
  Descriptor descriptor{};
  descriptor.link = link.link;
  descriptor.number = link.flow.sent();
  descriptor.size_bytes = message.data.bytes.size();
  descriptor.publisher = message.id.publisher;
  descriptor.incarnation = message.id.incarnation;
  descriptor.sequence = message.id.sequence;
  descriptor.publish_time_ns = message.publish_time_ns;
  descriptor.publish_monotonic_ns = message.publish_monotonic_ns;
  descriptor.latched = message.latched;
  descriptor.chain_origin = message.cause.chain_origin;
  descriptor.cause = message.cause.message;
  descriptor.chain_age_ns = message.cause.chain_age_ns;
  descriptor.unsent = message.cause.unsent;
  const bool in_memory = message.place && (message.place->segment == 0 || MayUse(pair, message.place->segment));
  if (in_memory) {
    descriptor.segment = message.place->segment;
    descriptor.offset_bytes = message.place->offset_bytes;
    pair.out.lane->Write(descriptor, queued.packed);
  } else {
    pair.socket.SendPayload(descriptor.link, descriptor.number, message.data);
    sockets_.FlushSoon(pair);
    descriptor.segment = kOnSocket;
    pair.out.lane->Write(descriptor, nullptr);
    sent_apart_.fetch_add(1, std::memory_order_relaxed);
  }
  link.core->sent.fetch_add(1, std::memory_order_relaxed);
  return in_memory;
}

void ShmPublisher::SendWaiting(Pair& pair) {
  Leavings leavings;
  Bells bells;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    if (!pair.out.lane) return;  // It has just ended.
    pair.hungry = false;
    pair.out.lane->SetHungry(0);
    Collect(pair, leavings);
    for (auto& [core, link] : pair.out.links) {
      Drain(*link, leavings, bells);
      if (!link->flow.lossless() || !core->refused.load()) continue;
      if (FindRoom(*core, leavings)) OutboundCore::TellRoom(link->core, actions);
    }
  }
  for (const auto& bell : bells) bell->Ring();
  for (const auto& action : actions) action();
  NotifyClose();
}

}  // namespace hgros::shm
