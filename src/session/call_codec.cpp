// A call on the wire: the head as field 536870911 of a protobuf message, and the body right behind it.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "hgros/call.pb.h"
#include "hgros/session/call_message.hpp"

namespace hgros::codec {
namespace {

// Field 536870911, length-delimited, as protobuf writes a tag. A parser that knows nothing of calls skips it, so the
// data of a protobuf type stay an ordinary message of that type.
constexpr std::array<unsigned char, 5> kTag{0xFA, 0xFF, 0xFF, 0xFF, 0x0F};
constexpr std::size_t kMaxLengthBytes = 5;

std::string HeadOf(const CallMessage& call, CallMessage::Outcome outcome, const std::string& text) {
  wire::CallHead head;
  head.set_caller(call.caller);
  head.set_server(call.server);
  head.set_call(call.call);
  head.set_patience_ns(static_cast<std::uint64_t>(call.patience_ns));
  head.set_reply_type(call.reply_type);
  head.set_cancelled(call.cancelled);
  head.set_outcome(static_cast<wire::CallOutcome>(outcome));
  head.set_text(text);
  const std::size_t size = head.ByteSizeLong();
  std::string written(reinterpret_cast<const char*>(kTag.data()), kTag.size());
  for (std::size_t rest = size; true; rest >>= 7U) {
    written.push_back(static_cast<char>((rest & 0x7FU) | (rest >= 0x80 ? 0x80U : 0U)));
    if (rest < 0x80) break;
  }
  head.AppendToString(&written);
  return written;
}

std::string HeadOf(const CallMessage& call) { return HeadOf(call, call.outcome, call.text); }

// Where the head lies and the body begins; false if there is none.
bool Split(Bytes data, Bytes& head, Bytes& body) {
  if (data.size() <= kTag.size() || std::memcmp(data.data(), kTag.data(), kTag.size()) != 0) return false;
  std::size_t at = kTag.size();
  std::uint64_t size = 0;
  for (std::size_t i = 0;; ++i) {
    if (i == kMaxLengthBytes || at == data.size()) return false;
    const auto byte = std::to_integer<std::uint64_t>(data[at++]);
    size |= (byte & 0x7FU) << (7 * i);
    if ((byte & 0x80U) == 0) break;
  }
  if (size > data.size() - at || size > std::numeric_limits<int>::max()) return false;
  head = data.subspan(at, size);
  body = data.subspan(at + size);
  return true;
}

Payload Joined(const std::string& head, Bytes body) {
  auto all = std::make_shared<std::string>();
  all->reserve(head.size() + body.size());
  all->append(head).append(AsText(body));
  return OwnString(std::move(all));
}

CallMessage::Outcome OutcomeOf(int number) {
  const bool known = number >= 0 && number <= static_cast<int>(CallMessage::Outcome::kTypeMismatch);
  return known ? static_cast<CallMessage::Outcome>(number) : CallMessage::Outcome::kHandlerFailed;
}

}  // namespace

Payload EncodeCall(const AnyMessage& message) {
  const auto& call = *static_cast<const CallMessage*>(message.get());
  if (!call.body) return Joined(HeadOf(call), {});
  const Payload body = call.type->encode(call.body);
  if (body.owner) return Joined(HeadOf(call), body.bytes);
  return Joined(HeadOf(call, CallMessage::Outcome::kNotWritable, "It could not be written as " + call.type->name + "."),
                {});
}

std::size_t EncodedCallBytes(const void* message) {
  const auto& call = *static_cast<const CallMessage*>(message);
  return HeadOf(call).size() + (call.body ? call.type->encoded_bytes(call.body.get()) : 0);
}

bool EncodeCallInto(const void* message, std::span<std::byte> bytes) {
  const auto& call = *static_cast<const CallMessage*>(message);
  const std::string head = HeadOf(call);
  if (head.size() > bytes.size()) return false;
  std::memcpy(bytes.data(), head.data(), head.size());
  return !call.body || call.type->encode_into(call.body.get(), bytes.subspan(head.size()));
}

AnyMessage DecodeCall(const Payload& payload, const TypeInfo& type) {
  Bytes head_bytes;
  Bytes body;
  wire::CallHead head;
  if (!Split(payload.bytes, head_bytes, body) ||
      !head.ParseFromArray(head_bytes.data(), static_cast<int>(head_bytes.size()))) {
    return nullptr;
  }
  auto call = std::make_shared<CallMessage>();
  call->caller = head.caller();
  call->server = head.server();
  call->call = head.call();
  call->patience_ns =
      static_cast<std::int64_t>(std::min<std::uint64_t>(head.patience_ns(), std::numeric_limits<std::int64_t>::max()));
  call->reply_type = std::move(*head.mutable_reply_type());
  call->cancelled = head.cancelled();
  call->outcome = OutcomeOf(head.outcome());
  call->text = std::move(*head.mutable_text());
  call->type = &type;
  if (call->cancelled || call->outcome != CallMessage::Outcome::kOk) return call;
  call->body = type.decode(Payload{body, payload.owner});
  if (!call->body) {  // The other side is told so instead of waiting.
    call->outcome = CallMessage::Outcome::kNotWritable;
    call->text = "Its data does not parse as " + type.name + ".";
  }
  return call;
}

}  // namespace hgros::codec
