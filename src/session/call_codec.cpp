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
#include "hgros/session/call_message.hpp"

namespace hgros::codec {
namespace {

// Field 536870911, length-delimited, as protobuf writes a tag. A parser that knows nothing of calls skips it, so the
// data of a protobuf type stay an ordinary message of that type.
constexpr std::array<unsigned char, 5> kTag{0xFA, 0xFF, 0xFF, 0xFF, 0x0F};
constexpr std::size_t kMaxLengthBytes = 5;

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

// Written in one go behind where its size, of kSizeBytes always, goes.
class CallHeadBytes {
 public:
  explicit CallHeadBytes(const CallMessage& call) : CallHeadBytes(call, call.outcome, call.text) {}
  CallHeadBytes(const CallMessage& call, CallMessage::Outcome outcome, std::string_view text) {
    const std::size_t most = kFixedPart + MaxTextField(call.reply_type) + MaxTextField(text);
    if (most > short_.size()) long_.resize(most);
    char* const begin = Begin();
    char* const fields = begin + kTag.size() + kSizeBytes;
    char* at = PutFixed64(fields, kCaller, call.caller);
    at = PutFixed64(at, kServer, call.server);
    at = PutNumber(at, kCall, call.call);
    at = PutNumber(at, kPatience, static_cast<std::uint64_t>(call.patience_ns));
    at = PutText(at, kReplyType, call.reply_type);
    at = PutNumber(at, kCancelled, call.cancelled ? 1U : 0U);
    at = PutNumber(at, kOutcome, static_cast<std::uint64_t>(outcome));
    at = PutText(at, kText, text);
    std::memcpy(begin, kTag.data(), kTag.size());
    // As many bytes for the size as it needs: the fields move up to it.
    const auto size = static_cast<std::size_t>(at - fields);
    char* const behind = PutVarint(begin + kTag.size(), size);
    std::memmove(behind, fields, size);
    size_ = static_cast<std::size_t>(behind - begin) + size;
  }
  CallHeadBytes(const CallHeadBytes&) = delete;
  CallHeadBytes& operator=(const CallHeadBytes&) = delete;

  [[nodiscard]] std::string_view view() const { return {long_.empty() ? short_.data() : long_.data(), size_}; }

 private:
  static constexpr std::size_t kSizeBytes = 10;
  static constexpr std::size_t kFixedPart = kTag.size() + kSizeBytes + 6 * kMaxNumberField;
  [[nodiscard]] char* Begin() { return long_.empty() ? short_.data() : long_.data(); }

  std::array<char, 256> short_;
  std::string long_;
  std::size_t size_ = 0;
};

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

Payload Joined(const CallHeadBytes& head, Bytes body) {
  auto all = std::make_shared<std::string>();
  all->reserve(head.view().size() + body.size());
  all->append(head.view()).append(AsText(body));
  return OwnString(std::move(all));
}

CallMessage::Outcome OutcomeOf(std::uint32_t number) {
  const bool known = number <= static_cast<std::uint32_t>(CallMessage::Outcome::kTypeMismatch);
  return known ? static_cast<CallMessage::Outcome>(number) : CallMessage::Outcome::kHandlerFailed;
}

// False if it is no head. The last of a field given twice counts, as in protobuf.
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
      case FieldTag(kText, kLengthDelimited): call.text = in.ReadText(); break;
      default: in.Skip(tag);
    }
  }
  return in.ok();
}

}  // namespace

Payload EncodeCall(const AnyMessage& message) {
  const auto& call = *static_cast<const CallMessage*>(message.get());
  if (!call.body) return Joined(CallHeadBytes(call), {});
  const Payload body = call.type->encode(call.body);
  if (body.owner) return Joined(CallHeadBytes(call), body.bytes);
  const std::string fault = "It could not be written as " + call.type->name + ".";
  return Joined(CallHeadBytes(call, CallMessage::Outcome::kNotWritable, fault), {});
}

std::size_t EncodedCallBytes(const void* message) {
  const auto& call = *static_cast<const CallMessage*>(message);
  return CallHeadBytes(call).view().size() + (call.body ? call.type->encoded_bytes(call.body.get()) : 0);
}

bool EncodeCallInto(const void* message, std::span<std::byte> bytes) {
  const auto& call = *static_cast<const CallMessage*>(message);
  const CallHeadBytes head(call);
  const std::string_view written = head.view();
  if (written.size() > bytes.size()) return false;
  std::memcpy(bytes.data(), written.data(), written.size());
  return !call.body || call.type->encode_into(call.body.get(), bytes.subspan(written.size()));
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
  if (!call->body) {  // The other side is told so instead of waiting.
    call->outcome = CallMessage::Outcome::kNotWritable;
    call->text = "Its data does not parse as " + type.name + ".";
  }
  return call;
}

}  // namespace hgros::codec
