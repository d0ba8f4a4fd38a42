#include "transport/zmq/subscribe/inbound_packet.hpp"

#include <cstddef>
#include <cstring>
#include <utility>

namespace hgros::zmq {
namespace {

// Below this size a copy is cheaper than keeping a whole receive buffer alive for one small message.
constexpr std::size_t kCopyInBelowBytes = 4096;

Payload PayloadOf(Message&& frame) {
  const Bytes bytes = frame.bytes();
  if (bytes.size() < kCopyInBelowBytes) {
    constexpr std::size_t kUnit = sizeof(std::max_align_t);
    auto copy = std::make_shared_for_overwrite<std::max_align_t[]>((bytes.size() + kUnit - 1) / kUnit + 1);
    if (!bytes.empty()) std::memcpy(copy.get(), bytes.data(), bytes.size());
    const Bytes copied{reinterpret_cast<const std::byte*>(copy.get()), bytes.size()};
    return {copied, std::move(copy)};
  }
  auto owner = std::make_shared<Message>(std::move(frame));
  const Bytes kept = owner->bytes();
  return {kept, std::move(owner)};
}

}  // namespace

LeaderPool::Task DeliverPacket(const std::shared_ptr<InboundCore>& core, InboundPacket&& packet, SharedState& shared,
                               const std::string& endpoint) {
  InboundMessage message;
  const auto drop = [&](PacketFault fault, const std::string& what) {
    ReportFault(*core, shared, endpoint, fault, "channel " + core->name + ": " + what);
  };
  if (const auto fault = DecodeHeadFrame(packet.head.bytes(), message.head); fault != PacketFault::kNone) {
    drop(fault, "its head cannot be read");
    return {};
  }
  if (const auto wrong = core->Check(message.head, packet.from, packet.fingerprint);
      wrong.fault != PacketFault::kNone) {
    drop(wrong.fault, wrong.what);
    return {};
  }
  message.data = PayloadOf(std::move(packet.data));
  message.from = packet.from;
  message.trusted = packet.trusted;
  message.schema = std::move(packet.schema);
  message.credit = std::move(packet.credit);
  return InboundCore::Deliver(core, std::move(message), shared.repeats);
}

void ReportFault(InboundCore& core, SharedState& shared, const std::string& where, PacketFault fault,
                 std::string_view what) {
  shared.CountFault(fault, where, what);
  core.TellFault(fault, what);
}

}  // namespace hgros::zmq
