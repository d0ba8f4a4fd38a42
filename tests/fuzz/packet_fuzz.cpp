#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "foxglove/SceneUpdate.pb.h"
#include "hgros/codec/message.hpp"
#include "hgros/codec/schema_compatibility.hpp"
#include "hgros/internal/codec/packet.hpp"

namespace {

/// Takes a frame off the input: two bytes of length (little-endian), then that many bytes or all that remain.
hgros::Bytes TakeFrame(hgros::Bytes& input) {
  if (input.size() < 2) return {};
  const std::size_t wanted = std::to_integer<std::size_t>(input[0]) | (std::to_integer<std::size_t>(input[1]) << 8U);
  const std::size_t size = std::min(wanted, input.size() - 2);
  const hgros::Bytes frame = input.subspan(2, size);
  input = input.subspan(2 + size);
  return frame;
}

void Require(bool holds) {
  if (!holds) std::abort();
}

/// What decodes must be the same after it is encoded and decoded again.
void CheckHead(hgros::Bytes frame) {
  hgros::PacketHead head;
  if (hgros::DecodeHeadFrame(frame, head) != hgros::PacketFault::kNone) return;
  std::string again;
  hgros::EncodeHeadFrame(head, again);
  hgros::PacketHead back;
  Require(hgros::DecodeHeadFrame(hgros::AsBytes(again), back) == hgros::PacketFault::kNone);
  Require(back.channel == head.channel && back.type_name == head.type_name && back.encoding == head.encoding &&
          back.fingerprint == head.fingerprint && back.id == head.id && back.publish_time_ns == head.publish_time_ns &&
          back.publish_monotonic_ns == head.publish_monotonic_ns && back.cause == head.cause);
}

void CheckTopic(hgros::Bytes frame) {
  const auto topic = hgros::ParseTopic(frame);
  if (!topic) return;
  const std::string again = topic->session == hgros::SessionId{} ? hgros::PlainTopic(topic->channel)
                                                                 : hgros::PeerTopic(topic->channel, topic->session);
  Require(again == hgros::AsText(frame));
}

void CheckData(hgros::Bytes bytes) {
  const hgros::TypeInfo& type = hgros::TypeOf<foxglove::SceneUpdate>();
  if (const hgros::AnyMessage message = type.decode({bytes, nullptr})) Require(type.encode(message).owner != nullptr);
  (void)hgros::CheckSchemas(hgros::AsText(bytes), type.name, *type.descriptor());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hgros::Bytes input = std::as_bytes(std::span(data, size));
  CheckTopic(TakeFrame(input));
  CheckHead(TakeFrame(input));
  CheckData(input);
  return 0;
}
