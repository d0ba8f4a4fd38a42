// A call on the wire: the head as field 536870911 of a protobuf message, and the body right behind it.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "codec/field_format.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/internal/codec/call_message.hpp"

namespace hgros::codec {
namespace {

// Field 536870911, length-delimited, as protobuf writes a tag. A parser that knows nothing of calls skips it, so the
// data of a protobuf type stay an ordinary message of that type.
constexpr std::array<unsigned char, 5> kTag{0xFA, 0xFF, 0xFF, 0xFF, 0x0F};

// The fields of CallHead in proto/hgros/call.proto.
enum CallField : std::uint32_t {
  kCaller = 1,
  kServer = 2,
  kCall = 3,
  kPatience = 4,
  kReplyType = 5,
  kCancelled = 6,
  kOutcome = 7,
  kText = 8,
};

// The bytes before the body.
struct CallHead {
  explicit CallHead(const CallMessage& of) : CallHead(of, of.outcome, of.text) {}
  CallHead(const CallMessage& of, CallMessage::Outcome its_outcome, std::string_view its_text)
      : call(of),
        outcome(static_cast<std::uint64_t>(its_outcome)),
        text(its_text),
        fields_size(SizeOfFixed64(call.caller) + SizeOfFixed64(call.server) + SizeOfNumber(call.call) +
                    SizeOfNumber(patience()) + SizeOfText(call.reply_type) + SizeOfNumber(cancelled()) +
                    SizeOfNumber(outcome) + SizeOfText(text)) {}

  [[nodiscard]] std::size_t size() const { return kTag.size() + SizeOfVarint(fields_size) + fields_size; }
  void WriteTo(char* at) const {
    std::memcpy(at, kTag.data(), kTag.size());
    at = PutVarint(at + kTag.size(), fields_size);
    at = PutFixed64(at, kCaller, call.caller);
    at = PutFixed64(at, kServer, call.server);
    at = PutNumber(at, kCall, call.call);
    at = PutNumber(at, kPatience, patience());
    at = PutText(at, kReplyType, call.reply_type);
    at = PutNumber(at, kCancelled, cancelled());
    at = PutNumber(at, kOutcome, outcome);
    PutText(at, kText, text);
  }

  [[nodiscard]] std::uint64_t patience() const { return static_cast<std::uint64_t>(call.patience_ns); }
  [[nodiscard]] std::uint64_t cancelled() const { return call.cancelled ? 1 : 0; }
  const CallMessage& call;
  const std::uint64_t outcome;
  const std::string_view text;
  const std::size_t fields_size;
};

// Finds the head and the body. False if there is no head.
bool Split(Bytes data, Bytes& head, Bytes& body) {
  if (data.size() <= kTag.size() || std::memcmp(data.data(), kTag.data(), kTag.size()) != 0) return false;
  FieldReader in(data.subspan(kTag.size()));
  head = AsBytes(in.ReadText());
  body = in.rest();
  return in.ok();
}

Payload Joined(const CallHead& head, Bytes body) {
  auto all = std::make_shared<std::string>();
  all->reserve(head.size() + body.size());
  all->resize(head.size());
  head.WriteTo(all->data());
  all->append(AsText(body));
  return OwnString(std::move(all));
}

CallMessage::Outcome OutcomeOf(std::uint32_t number) {
  const bool known = number <= static_cast<std::uint32_t>(CallMessage::Outcome::kTypeMismatch);
  return known ? static_cast<CallMessage::Outcome>(number) : CallMessage::Outcome::kHandlerFailed;
}

// False if it is not a head. If a field appears twice, the last one counts, as in protobuf.
bool ReadHead(Bytes head, CallMessage& call) {
  using enum FieldForm;
  FieldReader in(head);
  while (in.more()) {
    const std::uint32_t tag = in.ReadTag();
    switch (tag) {
      case FieldTag(kCaller, kFixed64): call.caller = in.ReadFixed<std::uint64_t>(); break;
      case FieldTag(kServer, kFixed64): call.server = in.ReadFixed<std::uint64_t>(); break;
      case FieldTag(kCall, kVarint): call.call = in.ReadVarint(); break;
      case FieldTag(kPatience, kVarint):
        call.patience_ns = static_cast<std::int64_t>(
            std::min<std::uint64_t>(in.ReadVarint(), std::numeric_limits<std::int64_t>::max()));
        break;
      case FieldTag(kReplyType, kLengthDelimited): call.reply_type = in.ReadText(); break;
      case FieldTag(kCancelled, kVarint): call.cancelled = in.ReadVarint() != 0; break;
      case FieldTag(kOutcome, kVarint): call.outcome = OutcomeOf(static_cast<std::uint32_t>(in.ReadVarint())); break;
      case FieldTag(kText, kLengthDelimited): call.text = AsUtf8(in.ReadText()); break;
      default: in.Skip(tag);
    }
  }
  return in.ok();
}

constexpr std::string_view kTooLargeFault = "It is larger than 1 GiB.";

bool IsTooLarge(const CallMessage& call) {
  return call.body && call.type->encoded_bytes != nullptr &&
         CallHead(call).size() + call.type->encoded_bytes(call.body.get()) > kMaxMessageBytes;
}

}  // namespace

Payload EncodeCall(const AnyMessage& message) {
  const auto& call = *static_cast<const CallMessage*>(message.get());
  if (!call.body) return Joined(CallHead(call), {});
  const auto refuse = [&call](std::string_view fault) {
    return Joined(CallHead(call, CallMessage::Outcome::kNotWritable, fault), {});
  };
  if (IsTooLarge(call)) return refuse(kTooLargeFault);
  const Payload body = call.type->encode(call.body);
  if (!body.owner) return refuse("It could not be written as " + call.type->name + ".");
  if (CallHead(call).size() + body.bytes.size() > kMaxMessageBytes) return refuse(kTooLargeFault);
  return Joined(CallHead(call), body.bytes);
}

std::size_t EncodedCallBytes(const void* message) {
  const auto& call = *static_cast<const CallMessage*>(message);
  const bool sized = call.body && call.type->encoded_bytes != nullptr;
  const std::size_t size = CallHead(call).size() + (sized ? call.type->encoded_bytes(call.body.get()) : 0);
  if (size > kMaxMessageBytes) return CallHead(call, CallMessage::Outcome::kNotWritable, kTooLargeFault).size();
  return size;
}

bool EncodeCallInto(const void* message, std::span<std::byte> bytes) {
  const auto& call = *static_cast<const CallMessage*>(message);
  const CallHead head(call);
  const std::size_t size = head.size();
  if (size > bytes.size()) return false;
  // The bytes may be the room for a refusal: EncodeCall() writes it.
  const CallHead refusal(call, CallMessage::Outcome::kNotWritable, kTooLargeFault);
  if (bytes.size() == refusal.size() && IsTooLarge(call)) return false;
  if (call.body && call.type->encode_into == nullptr) return false;
  head.WriteTo(reinterpret_cast<char*>(bytes.data()));
  return !call.body || call.type->encode_into(call.body.get(), bytes.subspan(size));
}

AnyMessage DecodeCall(const Payload& payload, const TypeInfo& type) {
  Bytes head;
  Bytes body;
  if (!Split(payload.bytes, head, body)) return nullptr;
  auto call = std::make_shared<CallMessage>();
  if (!ReadHead(head, *call)) return nullptr;
  call->type = &type;
  if (call->cancelled || call->outcome != CallMessage::Outcome::kOk) return call;
  call->body = type.decode(Payload{body, payload.owner});
  if (!call->body) {  // The other side gets this failure and need not wait.
    call->outcome = CallMessage::Outcome::kNotWritable;
    call->text = "The data does not parse as " + type.name + ".";
  }
  return call;
}

}  // namespace hgros::codec
