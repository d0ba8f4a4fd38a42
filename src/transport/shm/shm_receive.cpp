// How messages come in: the reading thread takes descriptors from the lanes whose publishers have rung.
#include <algorithm>
#include <cstring>
#include <utility>

#include "transport/shm/shm_core.hpp"

namespace hgros::shm {
namespace {

constexpr int kBatch = 64;  // Messages of one peer before others have their turn.

// A payload in the publisher's memory: its slot goes back when nobody reads it any more.
struct Borrow {
  Borrow(std::shared_ptr<Slip> of, std::shared_ptr<Mapping> where, std::uint32_t number) noexcept
      : slip(std::move(of)), segment(std::move(where)), slot(number) {}
  ~Borrow() { slip->Return(slot); }
  Borrow(const Borrow&) = delete;
  Borrow& operator=(const Borrow&) = delete;
  const std::shared_ptr<Slip> slip;
  const std::shared_ptr<Mapping> segment;
  const std::uint32_t slot;
};

Payload CopyOf(Bytes bytes) {
  constexpr std::size_t kUnit = sizeof(std::max_align_t);
  auto copy = std::make_shared_for_overwrite<std::max_align_t[]>((bytes.size() + kUnit - 1) / kUnit + 1);
  if (!bytes.empty()) std::memcpy(copy.get(), bytes.data(), bytes.size());
  const Bytes copied{reinterpret_cast<const std::byte*>(copy.get()), bytes.size()};
  return {copied, std::move(copy)};
}

}  // namespace

void ShmCore::Wait() noexcept { bell_.Wait(); }

void ShmCore::Wake() noexcept { bell_.Wake(); }

LeaderPool::Task ShmCore::Lead() noexcept {
  for (;;) {
    if (!bell_.Take([this](std::uint32_t number) { to_serve_.push_back(number); })) return {};
    // In turn, from behind the one that was served last: one that always has something does not keep the others
    // waiting.
    std::rotate(to_serve_.begin(), std::ranges::upper_bound(to_serve_, last_served_), to_serve_.end());
    for (std::size_t i = 0; i < to_serve_.size(); ++i) {
      const std::uint32_t number = last_served_ = to_serve_[i];
      const auto pair = PairAt(number);
      if (!pair) continue;
      if (pair->hungry.load()) Pump(*pair);
      auto task = Serve(pair);
      if (!task) continue;
      // Another thread looks at the rest.
      for (++i; i < to_serve_.size(); ++i) bell_.Ring(to_serve_[i]);
      to_serve_.clear();
      bell_.PassOn();
      return task;
    }
    to_serve_.clear();
    if (LeaderPool::IsVisitor()) return {};  // It has something else to look after; what is left has rung.
  }
}

LeaderPool::Task ShmCore::Serve(const std::shared_ptr<Pair>& pair) {
  for (int i = 0; i < kBatch; ++i) {
    std::shared_ptr<InLink> link;
    InboundMessage message;
    const char* lie = nullptr;
    Step step = Next(*pair, link, message, lie);
    if (step == Step::kLie && pair->ending.load()) step = Step::kNothing;  // It has ended for another reason.
    switch (step) {
      case Step::kSkipped: continue;
      case Step::kNotYet: return {};
      case Step::kLie: Distrust(*pair, lie); return {};
      case Step::kNothing:
        if (pair->ending.load() && !pair->finishing.exchange(true)) Post([this, pair] { FinishPair(pair); });
        return {};
      case Step::kMessage: break;
    }
    // What follows from the link is checked once.
    if (!link->checked || message.head.id.publisher != message.from.value) {
      if (const auto wrong = link->core->Check(message.head, message.from, link->fingerprint);
          wrong.fault != PacketFault::kNone) {
        faults_[static_cast<std::size_t>(wrong.fault)].fetch_add(1, std::memory_order_relaxed);
        link->core->TellFault(wrong.fault, wrong.what);
        continue;
      }
      link->checked = true;
    }
    auto task = InboundCore::Deliver(link->core, std::move(message), repeats_);
    if (!task) continue;
    const std::scoped_lock lock(pair->in_mutex);
    Descriptor next;
    if (pair->ending.load() || (pair->in && pair->in->Peek(next) != LaneReader::Read::kNothing)) {
      bell_.Ring(pair->number);
    }
    return task;
  }
  bell_.Ring(pair->number);
  return {};
}

ShmCore::Step ShmCore::Next(Pair& pair, std::shared_ptr<InLink>& link, InboundMessage& message, const char*& lie) {
  Descriptor descriptor;
  const std::scoped_lock lock(pair.in_mutex);
  for (; !pair.after.empty(); pair.after.pop_back()) {
    if (!pair.after.back()->finishing.load()) return Step::kNotYet;
  }
  if (!pair.in) return Step::kNothing;
  switch (pair.in->Peek(descriptor)) {
    case LaneReader::Read::kNothing: return Step::kNothing;
    case LaneReader::Read::kLie: lie = "its lane has more messages than slots"; return Step::kLie;
    case LaneReader::Read::kDescriptor: break;
  }
  if (descriptor.slot >= kSlots) {
    lie = "a message has a slot that there is not";
    return Step::kLie;
  }
  const auto found = pair.in_links.find(descriptor.link);
  if (found == pair.in_links.end()) {  // Just unsubscribed.
    pair.in->Next();
    pair.slip->Hold();
    pair.slip->Return(descriptor.slot);
    return Step::kSkipped;
  }
  link = found->second;
  // What the message needs comes over the socket, and may be slower.
  std::shared_ptr<Mapping> segment;
  auto apart = pair.apart.end();
  bool there = link->granted;
  if (descriptor.segment == kOnSocket) {
    apart = pair.apart.find({descriptor.link, descriptor.number});
    there = there && apart != pair.apart.end();
  } else if (descriptor.segment != 0) {
    const auto known = pair.segments.find(descriptor.segment);
    there = there && known != pair.segments.end();
    if (there) segment = known->second;
  }
  if (!there) {
    pair.blocked = true;
    return Step::kNothing;
  }
  if (descriptor.number != link->receipt->received() + 1) {
    lie = "its messages are not numbered one after the other";
    return Step::kLie;
  }
  if (!link->receipt->HasRoom()) {
    lie = "it sent more than it had credit for";
    return Step::kLie;
  }
  if (descriptor.segment == kOnSocket
          ? descriptor.size_bytes != apart->second.size()
          : descriptor.size_bytes > (segment ? segment->bytes().size() : 0) ||
                descriptor.offset_bytes > (segment ? segment->bytes().size() : 0) - descriptor.size_bytes) {
    lie = "a message lies outside of its memory";
    return Step::kLie;
  }
  if (descriptor.size_bytes > options_.max_message_bytes) {
    lie = "a message is larger than it may send";
    return Step::kLie;
  }
  pair.in->Next();
  pair.slip->Hold();
  message.credit = link->receipt->Take(descriptor.size_bytes);
  if (descriptor.segment == kOnSocket) {
    pair.slip->Return(descriptor.slot);
    auto owner = std::make_shared<const std::string>(std::move(apart->second));
    link->apart_bytes -= descriptor.size_bytes;
    pair.apart.erase(apart);
    message.data = {AsBytes(*owner), owner};
  } else {
    message.data = PayloadOf(pair.slip, descriptor, std::move(segment));
  }
  message.from = pair.facts.info.id;
  message.head.channel = link->core->name;
  message.head.type_name = link->type_name;
  message.head.encoding = link->encoding;
  message.head.fingerprint = link->fingerprint;
  message.schema = link->schema;
  message.head.id = {descriptor.publisher, descriptor.incarnation, descriptor.sequence};
  message.head.publish_time_ns = descriptor.publish_time_ns;
  message.head.publish_monotonic_ns = descriptor.publish_monotonic_ns;
  message.head.latched = descriptor.latched;
  if (link->ends_after == link->receipt->received()) {
    PostFor(pair, [this, ended = link->link](const auto& owner) { EndLink(*owner, ended); });
  }
  return Step::kMessage;
}

Payload ShmCore::PayloadOf(const std::shared_ptr<Slip>& slip, const Descriptor& descriptor,
                           std::shared_ptr<Mapping> segment) {
  if (!segment) {
    slip->Return(descriptor.slot);
    return CopyOf({});
  }
  const Bytes bytes = segment->bytes().subspan(descriptor.offset_bytes, descriptor.size_bytes);
  // Who keeps many messages must not use up the slots that others need.
  if (slip->held() > kSlots / 2) {
    Payload copy = CopyOf(bytes);
    slip->Return(descriptor.slot);
    return copy;
  }
  return {bytes, std::make_shared<const Borrow>(slip, std::move(segment), descriptor.slot)};
}

void ShmCore::Distrust(Pair& liar, const std::string& what) {
  if (liar.ending.load()) return;
  PostFor(liar, [this, what](const auto& pair) {
    if (pair->ending.load()) return;
    faults_[static_cast<std::size_t>(PacketFault::kHead)].fetch_add(1, std::memory_order_relaxed);
    log_.WriteLimited(LogLevel::kWarning, "shm lie " + pair->facts.info.id.ToString(),
                      "The shared memory of " + pair->facts.info.process + " (session " +
                          pair->facts.info.id.ToString() + ") cannot be right: " + what +
                          ". The connection is ended and made anew.");
    {
      // What else it says is not read.
      const std::scoped_lock lock(pair->in_mutex);
      pair->in.reset();
    }
    EndPair(pair, "its shared memory cannot be right", true);
  });
}

}  // namespace hgros::shm
