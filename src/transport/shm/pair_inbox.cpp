#include "transport/shm/pair_inbox.hpp"

#include <cstring>
#include <utility>

namespace hgros::shm {
namespace {

// A payload in the publisher's memory. Its slot is returned when the last reader ends.
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

PairInbox::Step PairInbox::Next(Arrival& arrival, std::uint64_t max_message_bytes) {
  Descriptor descriptor;
  const auto lie = [&arrival](const char* what) {
    arrival.lie = what;
    return Step::kLie;
  };
  const std::scoped_lock lock(mutex_);
  for (; !earlier_.empty(); earlier_.pop_back()) {
    if (!earlier_.back()->ended()) return Step::kNotYet;
  }
  if (!lane_) return Step::kNothing;
  switch (lane_->Peek(descriptor)) {
    case LaneReader::Read::kNothing: return Step::kNothing;
    case LaneReader::Read::kLie: return lie("its lane has more messages than slots");
    case LaneReader::Read::kDescriptor: break;
  }
  if (descriptor.slot >= kSlots) return lie("a message has a slot number that does not exist");
  const auto found = links_.find(descriptor.link);
  if (found == links_.end()) {  // Just unsubscribed.
    lane_->Next();
    slip_->Hold();
    slip_->Return(descriptor.slot);
    return Step::kSkipped;
  }
  InLink& link = *found->second;
  // The segment or payload of the message comes over the socket, which may be slower.
  std::shared_ptr<Mapping> segment;
  if (const auto known = segments_.find(descriptor.segment); known != segments_.end()) segment = known->second;
  // The payload of a message in a segment comes here if the segment could not be mapped.
  const auto apart = apart_.empty() ? apart_.end() : apart_.find({descriptor.link, descriptor.number});
  const bool by_socket = apart != apart_.end();
  if (!link.granted || (!segment && !by_socket && descriptor.segment != 0)) {
    blocked_ = true;
    return Step::kNothing;
  }
  if (descriptor.number != link.receipt->received() + 1) return lie("its messages are not numbered consecutively");
  if (!link.receipt->HasRoom()) return lie("it sent more than it had credit for");
  const bool lost = by_socket && !apart->second.owner;
  if (by_socket ? !lost && descriptor.size_bytes != apart->second.bytes.size()
                : descriptor.size_bytes > (segment ? segment->bytes().size() : 0) ||
                      descriptor.offset_bytes > (segment ? segment->bytes().size() : 0) - descriptor.size_bytes) {
    return lie("a message lies outside of its memory");
  }
  if (descriptor.size_bytes > max_message_bytes) return lie("a message is larger than it may send");
  lane_->Next();
  slip_->Hold();
  InboundMessage& message = arrival.message;
  message.credit = link.receipt->AdmitMessage(descriptor.size_bytes);
  arrival.link = found->second;
  arrival.ends = link.ends_after == link.receipt->received();
  if (by_socket) {
    slip_->Return(descriptor.slot);
    message.data = std::move(apart->second);
    link.apart_bytes -= message.data.bytes.size();
    apart_.erase(apart);
    if (lost) return Step::kLost;
  } else {
    message.data = PayloadOf(slip_, descriptor, std::move(segment));
  }
  message.from = from_;
  message.trusted = true;  // A pair is only made with a process of the same user.
  message.head.channel = link.core->name;
  message.head.type_name = link.type_name;
  message.head.encoding = link.encoding;
  message.head.fingerprint = link.fingerprint;
  message.schema = link.schema;
  message.head.id = {descriptor.publisher, descriptor.incarnation, descriptor.sequence};
  message.head.publish_time_ns = descriptor.publish_time_ns;
  message.head.publish_monotonic_ns = descriptor.publish_monotonic_ns;
  message.head.latched = descriptor.latched;
  message.head.cause = {descriptor.cause, descriptor.chain_age_ns, descriptor.chain_origin, descriptor.unsent};
  return Step::kMessage;
}

Payload PairInbox::PayloadOf(const std::shared_ptr<Slip>& slip, const Descriptor& descriptor,
                             std::shared_ptr<Mapping> segment) {
  if (!segment) {
    slip->Return(descriptor.slot);
    return CopyOf({});
  }
  const Bytes bytes = segment->bytes().subspan(descriptor.offset_bytes, descriptor.size_bytes);
  // A receiver that keeps many messages must not take all slots.
  if (slip->held() > kSlots / 2) {
    Payload copy = CopyOf(bytes);
    slip->Return(descriptor.slot);
    return copy;
  }
  return {bytes, std::make_shared<const Borrow>(slip, std::move(segment), descriptor.slot)};
}

}  // namespace hgros::shm
