// How messages leave: under the mutex into the lanes, and the bells are rung after it.
#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "transport/shm/shm_core.hpp"

namespace hgros::shm {

std::shared_ptr<const ShmMessage> ShmCore::Pack(const PacketHead& head, const Payload& data) {
  auto message = std::make_shared<ShmMessage>();
  message->id = head.id;
  message->publish_time_ns = head.publish_time_ns;
  message->publish_monotonic_ns = head.publish_monotonic_ns;
  message->latched = head.latched;
  if (data.bytes.empty()) {
    message->place = Place{};
    return message;
  }
  if (data.owner) message->place = pool_->Find(data.bytes);
  if (message->place) {
    message->data = data;
    return message;
  }
  std::string fault;
  if (auto loan = pool_->Take(data.bytes.size(), &fault)) {
    std::memcpy(loan->bytes.data(), data.bytes.data(), data.bytes.size());
    message->place = loan->place;
    message->data = {loan->bytes, std::move(loan->owner)};
    return message;
  }
  log_.WriteLimited(LogLevel::kWarning, "shm apart",
                    "There is no shared memory for a message of " + std::to_string(data.bytes.size()) +
                        " bytes on channel \"" + head.channel + "\": " + fault +
                        ". It goes over a socket, which takes longer. Raise the limit of shared memory, or let go of "
                        "messages sooner.");
  if (data.owner) {
    message->data = data;
  } else {
    auto copy = std::make_shared<const std::string>(AsText(data.bytes));
    message->data = {AsBytes(*copy), copy};
  }
  return message;
}

bool ShmCore::HasRoom(const OutChannel& channel) {
  return std::ranges::all_of(channel.links,
                             [](const OutLink* link) { return !link->flow.lossless() || link->flow.HasRoom(); });
}

// First by what is known, then by what the peers say now, and last after they were asked to tell.
bool ShmCore::FindRoom(const OutChannel& channel, Leavings& leavings) {
  if (HasRoom(channel)) return true;
  for (const bool asked : {false, true}) {
    for (OutLink* link : channel.links) {
      if (!link->flow.lossless()) continue;
      if (asked) {
        link->pair.hungry = true;
        link->pair.out->SetHungry(link->pair.out->hungry() | kForCredit);
      }
      ReadCredit(*link, leavings);
    }
    if (HasRoom(channel)) return true;
  }
  return false;
}

PublishStatus ShmCore::Reserve(OutChannel& channel) {
  if (closing_.load(std::memory_order_relaxed)) return PublishStatus::kClosed;
  if (channel.lossless.load() == 0) return PublishStatus::kOk;
  Leavings leavings;
  const std::scoped_lock lock(mutex_);
  if (!HasRoom(channel)) {
    channel.refused = true;  // Before asking: the answer may come at once.
    if (!FindRoom(channel, leavings)) return PublishStatus::kFull;
  }
  for (OutLink* link : channel.links) {
    if (link->flow.lossless()) link->flow.Reserve();
  }
  return PublishStatus::kOk;
}

void ShmCore::Cancel(const std::shared_ptr<OutChannel>& core) {
  if (core->lossless.load() == 0) return;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    for (OutLink* link : core->links) link->flow.CancelReservation();
    if (HasRoom(*core)) OutboundCore::TellRoom(core, actions);
  }
  Post(std::move(actions));
}

void ShmCore::Commit(const std::shared_ptr<OutChannel>& core, const PacketHead& head, const Payload& data) {
  if (closing_.load(std::memory_order_relaxed) || core->subscribers.load(std::memory_order_relaxed) == 0) return;
  const auto message = Pack(head, data);
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
      if (!Accepts(*link, *message, actions)) {
        link->flow.CancelReservation();
        skipped = true;
        continue;
      }
      skipped = !link->flow.Push({message, message->id, message->data.bytes.size()}) || skipped;
      if (Send(*link, leavings)) bells.push_back(link->pair.bell);
    }
    // Its reservation is free again, and somebody may have been refused meanwhile.
    if (skipped && HasRoom(*core)) OutboundCore::TellRoom(core, actions);
  }
  // Before all that can wait until the receivers are on their way.
  for (const auto& bell : bells) bell->Ring();
  bells.clear();
  {
    const std::scoped_lock lock(mutex_);
    for (OutLink* link : core->links) Drain(*link, leavings, bells);
  }
  for (const auto& bell : bells) bell->Ring();
  Post(std::move(actions));
}

// A message that is larger than the peer takes is kept from it, counted on both sides and said.
bool ShmCore::Accepts(OutLink& link, const ShmMessage& message, Actions& actions) {
  const std::uint64_t size = message.data.bytes.size();
  const std::uint64_t limit = link.pair.max_message_bytes;
  if (size <= limit) return true;
  (link.flow.lossless() ? link.core->missed : link.core->dropped).fetch_add(1, std::memory_order_relaxed);
  if (link.too_large++ == 0) {
    actions.emplace_back([this, to = link.pair.shared_from_this(), channel = link.core->name, size, limit] {
      log_.WriteLimited(LogLevel::kWarning, "shm large " + channel + " " + to->facts.info.id.ToString(),
                        "A message of " + std::to_string(size) + " bytes on channel \"" + channel +
                            "\" is not sent to " + to->facts.info.process + " (session " +
                            to->facts.info.id.ToString() + "), which takes at most " + std::to_string(limit) +
                            ". Publish smaller messages, or raise its limit.");
    });
  }
  link.too_large_bytes = size;
  SayTooLarge(link);
  return false;
}

// What the peer does not read yet is told later, in one frame.
void ShmCore::SayTooLarge(OutLink& link) {
  if (link.told_too_large == link.too_large || !link.pair.socket.all_sent()) return;
  link.told_too_large = link.too_large;
  wire::PairMessage said;
  said.mutable_too_large()->set_link(link.link);
  said.mutable_too_large()->set_messages(link.too_large);
  said.mutable_too_large()->set_bytes(link.too_large_bytes);
  link.pair.socket.Send(said);
}

void ShmCore::ReadCredit(OutLink& link, Leavings& leavings) {
  const auto consumed = link.pair.out->ConsumedOf(link.cell);
  if (link.flow.Confirm(consumed.messages, consumed.bytes, leavings.messages)) return;
  Distrust(link.pair, "it says that it has consumed more than it was sent");
}

void ShmCore::Collect(Pair& pair, Leavings& leavings) {
  if (pair.out->Collect(leavings.owners)) return;
  Distrust(pair, "it returns what it was not given");
}

bool ShmCore::Send(OutLink& link, Leavings& leavings) {
  bool any = false;
  while (link.pair.out->HasSlot()) {
    auto message = link.flow.Pop();
    if (!message) break;
    Write(link, *message);
    // One that has gone over the socket may end with it.
    if (!static_cast<const ShmMessage&>(*message->packed).place) leavings.messages.push_back(std::move(*message));
    any = true;
  }
  return any;
}

void ShmCore::Drain(OutLink& link, Leavings& leavings, Bells& bells) {
  Pair& pair = link.pair;
  bool sent = Send(link, leavings);
  Collect(pair, leavings);
  if (link.flow.lossless() || link.flow.waiting() > 0) ReadCredit(link, leavings);
  if (link.flow.waiting() > 0) {
    sent = Send(link, leavings) || sent;
    // Each time after having asked for what is missing: what came before the peer read that rings no bell.
    for (std::uint32_t asked = 0; link.flow.waiting() > 0;) {
      const std::uint32_t missing = kForCredit | (pair.out->HasSlot() ? 0 : kForSlots);
      if ((asked & missing) == missing) break;
      asked |= missing;
      pair.hungry = true;
      pair.out->SetHungry(pair.out->hungry() | missing);
      Collect(pair, leavings);
      ReadCredit(link, leavings);
      sent = Send(link, leavings) || sent;
    }
  }
  if (sent) bells.push_back(pair.bell);
  const std::uint64_t others = pair.waiting_bytes - link.counted_bytes;
  const std::uint64_t limit = options_.peer_queue_bytes;
  if (const auto count = link.flow.Trim(limit > others ? limit - others : 0, leavings.messages); count > 0) {
    link.core->dropped.fetch_add(count, std::memory_order_relaxed);
  }
  CountWaiting(link);
}

void ShmCore::Write(OutLink& link, const PendingMessage& queued) {
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
  if (message.place) {
    const std::uint32_t segment = message.place->segment;
    if (segment != 0 && pair.told_segments.insert(segment).second) {
      wire::PairMessage said;
      said.mutable_segment_added()->set_segment(segment);
      pair.socket.Send(said, {pool_->HandleOf(segment)});
    }
    descriptor.segment = segment;
    descriptor.offset_bytes = message.place->offset_bytes;
    pair.out->Write(descriptor, queued.packed);
  } else {
    wire::PairMessage said;
    said.mutable_payload()->set_link(descriptor.link);
    said.mutable_payload()->set_number(descriptor.number);
    said.mutable_payload()->set_data(message.data.bytes.data(), message.data.bytes.size());
    pair.socket.Send(said);
    descriptor.segment = kOnSocket;
    pair.out->Write(descriptor, nullptr);
    sent_apart_.fetch_add(1, std::memory_order_relaxed);
  }
  link.core->sent.fetch_add(1, std::memory_order_relaxed);
}

void ShmCore::CountWaiting(OutLink& link) {
  const std::uint64_t now = link.flow.waiting_bytes();
  link.pair.waiting_bytes += now - link.counted_bytes;  // Wraps around to the right sum.
  link.core->queued_bytes.fetch_add(now - link.counted_bytes, std::memory_order_relaxed);
  link.counted_bytes = now;
}

void ShmCore::Pump(Pair& pair) {
  Leavings leavings;
  Bells bells;
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    if (!pair.out) return;  // It has just ended.
    pair.hungry = false;
    pair.out->SetHungry(0);
    Collect(pair, leavings);
    for (auto& [name, wish] : pair.wishes) {
      if (!wish.link) continue;
      OutLink& link = *wish.link;
      Drain(link, leavings, bells);
      if (!link.flow.lossless() || !link.core->refused.load()) continue;
      if (FindRoom(*link.core, leavings)) OutboundCore::TellRoom(link.core, actions);
    }
  }
  for (const auto& bell : bells) bell->Ring();
  for (const auto& action : actions) action();
  CountRound();
}

void ShmCore::RemoveSegments(Pair& pair, const std::vector<std::uint32_t>& gone) {
  for (const std::uint32_t segment : gone) {
    if (pair.told_segments.erase(segment) == 0) continue;
    wire::PairMessage said;
    said.mutable_segment_removed()->set_segment(segment);
    pair.socket.Send(said);
  }
}

std::optional<Block> ShmCore::Loan(std::size_t size_bytes) {
  auto loan = pool_->Take(size_bytes);
  if (!loan) return std::nullopt;
  return Block::Adopt(loan->bytes, std::move(loan->owner));
}

}  // namespace hgros::shm
