#include "hgros/internal/codec/packet.hpp"

#include <algorithm>
#include <limits>

#include "codec/field_format.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"

namespace hgros {
namespace {

constexpr std::size_t kPrefixBytes = 6;  // header_length and header_separator
constexpr char kPlainMark = '\0';
constexpr char kPeerMark = '\1';
constexpr std::size_t kSessionDigits = 16;

/// The fields of Head in proto/hgros/wire.proto.
enum Field : std::uint32_t {
  kVersion = 1,
  kChannel = 2,
  kType = 4,
  kEncoding = 5,
  kFingerprint = 6,
  kPublisherId = 7,
  kIncarnation = 8,
  kSequence = 9,
  kPublishTime = 10,
  kPublishMonotonic = 11,
  kLatched = 12,
  kCause = 13,
  kChainAge = 14,
  kChainOrigin = 15,
  kUnsent = 16,
};

constexpr std::uint32_t Tag(Field field, codec::FieldForm form) { return codec::FieldTag(field, form); }

/// The fields of a head that are not in PacketHead.
struct Preamble {
  std::uint32_t version = 0;
  std::uint32_t encoding = 0;
};

// The encoding of protobuf's sint64.
constexpr std::uint64_t ZigZag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1U) ^ (value < 0 ? ~std::uint64_t{0} : 0);
}
constexpr std::int64_t UnZigZag(std::uint64_t value) {
  return static_cast<std::int64_t>((value >> 1U) ^ (~(value & 1U) + 1));
}

char* PutCause(char* at, const CauseHead& cause) {
  using enum codec::FieldForm;
  at = codec::PutFixed64(at, kCause, cause.message);
  at = codec::PutNumber(at, kChainAge, cause.chain_age_ns);
  if (cause.chain_origin != 0) {
    *at++ = static_cast<char>(Tag(kChainOrigin, kFixed32));
    at = codec::PutLittleEndian(at, cause.chain_origin);
  }
  if (cause.unsent == 0) return at;
  at = codec::PutVarint(at, Tag(kUnsent, kVarint));
  return codec::PutVarint(at, ZigZag(cause.unsent));
}

void ReadField(codec::FieldReader& in, PacketHead& head, Preamble& preamble) {
  using enum codec::FieldForm;
  const std::uint32_t tag = in.ReadTag();
  switch (tag) {
    case Tag(kVersion, kFixed32): preamble.version = in.ReadFixed<std::uint32_t>(); break;
    case Tag(kChannel, kLengthDelimited): head.channel = in.ReadText(); break;
    case Tag(kType, kLengthDelimited): head.type_name = in.ReadText(); break;
    case Tag(kEncoding, kVarint): preamble.encoding = static_cast<std::uint32_t>(in.ReadVarint()); break;
    case Tag(kFingerprint, kFixed64): head.fingerprint = in.ReadFixed<std::uint64_t>(); break;
    case Tag(kPublisherId, kFixed64): head.id.publisher = in.ReadFixed<std::uint64_t>(); break;
    case Tag(kIncarnation, kFixed64): head.id.incarnation = in.ReadFixed<std::uint64_t>(); break;
    case Tag(kSequence, kVarint): head.id.sequence = in.ReadVarint(); break;
    case Tag(kPublishTime, kFixed64):
      head.publish_time_ns = static_cast<std::int64_t>(in.ReadFixed<std::uint64_t>());
      break;
    case Tag(kPublishMonotonic, kFixed64):
      head.publish_monotonic_ns = static_cast<std::int64_t>(in.ReadFixed<std::uint64_t>());
      break;
    case Tag(kLatched, kVarint): head.latched = static_cast<std::uint32_t>(in.ReadVarint()); break;
    case Tag(kCause, kFixed64): head.cause.message = in.ReadFixed<std::uint64_t>(); break;
    case Tag(kChainAge, kVarint): head.cause.chain_age_ns = in.ReadVarint(); break;
    case Tag(kChainOrigin, kFixed32): head.cause.chain_origin = in.ReadFixed<std::uint32_t>(); break;
    case Tag(kUnsent, kVarint): head.cause.unsent = UnZigZag(in.ReadVarint()); break;
    default: in.Skip(tag);
  }
}

PacketFault DecodeHead(Bytes head_str, PacketHead& head) {
  codec::FieldReader in(head_str);
  Preamble preamble;
  while (in.more()) ReadField(in, head, preamble);
  // The version is checked first: in another major version the other fields may have another meaning.
  if (preamble.version != 0 && (preamble.version >> 16U) != kWireMajor) return PacketFault::kVersion;
  if (!in.ok() || !ChannelNameFault(head.channel).empty() || !IsUtf8(head.type_name)) return PacketFault::kHead;
  if (preamble.encoding > static_cast<std::uint32_t>(Encoding::kPlain)) return PacketFault::kType;
  head.encoding = static_cast<Encoding>(preamble.encoding);
  return PacketFault::kNone;
}

void Clear(PacketHead& head) {
  head.channel.clear();
  head.type_name.clear();
  head.encoding = Encoding::kNone;
  head.fingerprint = 0;
  head.id = {};
  head.publish_time_ns = 0;
  head.publish_monotonic_ns = 0;
  head.latched = 0;
  head.cause = {};
}

/// The id that 16 lower-case hexadecimal digits stand for. Other spellings are invalid: they would be other topics.
SessionId ReadSession(std::string_view digits) noexcept {
  const auto lower = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  return std::ranges::all_of(digits, lower) ? SessionId::FromString(digits) : SessionId{};
}

}  // namespace

std::string_view ToString(PacketFault fault) noexcept {
  switch (fault) {
    case PacketFault::kNone: return "none";
    case PacketFault::kTruncated: return "truncated";
    case PacketFault::kSeparator: return "separator";
    case PacketFault::kLength: return "length";
    case PacketFault::kVersion: return "version";
    case PacketFault::kHead: return "head";
    case PacketFault::kTopic: return "topic";
    case PacketFault::kType: return "type";
    case PacketFault::kData: return "data";
    case PacketFault::kOverrun: return "overrun";
  }
  return "unknown";
}

void EncodeHeadFrame(const PacketHead& head, std::string& frame) {
  // Tags, two fixed32, six fixed64, five varints and two text lengths take less than this.
  constexpr std::size_t kMaxFixedPart = 160;
  frame.resize(kPrefixBytes + kMaxFixedPart + head.channel.size() + head.type_name.size());
  char* const begin = frame.data();
  char* at = begin + kPrefixBytes;
  *at++ = static_cast<char>(Tag(kVersion, codec::FieldForm::kFixed32));
  at = codec::PutLittleEndian(at, (kWireMajor << 16U) | kWireMinor);
  at = codec::PutText(at, kChannel, head.channel);
  at = codec::PutText(at, kType, head.type_name);
  at = codec::PutNumber(at, kEncoding, static_cast<std::uint64_t>(head.encoding));
  at = codec::PutFixed64(at, kFingerprint, head.fingerprint);
  at = codec::PutFixed64(at, kPublisherId, head.id.publisher);
  at = codec::PutFixed64(at, kIncarnation, head.id.incarnation);
  at = codec::PutNumber(at, kSequence, head.id.sequence);
  at = codec::PutFixed64(at, kPublishTime, static_cast<std::uint64_t>(head.publish_time_ns));
  at = codec::PutFixed64(at, kPublishMonotonic, static_cast<std::uint64_t>(head.publish_monotonic_ns));
  at = codec::PutNumber(at, kLatched, head.latched);
  at = PutCause(at, head.cause);
  const auto size = static_cast<std::size_t>(at - begin);
  codec::PutLittleEndian(begin, static_cast<std::uint32_t>(size - kPrefixBytes));
  codec::PutLittleEndian(begin + 4, kHeaderSeparator);
  frame.resize(size);
}

PacketFault DecodeHeadFrame(Bytes frame, PacketHead& head) {
  Clear(head);
  if (frame.size() < kPrefixBytes) return PacketFault::kTruncated;
  if (codec::GetLittleEndian<std::uint16_t>(frame.data() + 4) != kHeaderSeparator) return PacketFault::kSeparator;
  const std::size_t length = codec::GetLittleEndian<std::uint32_t>(frame.data());
  const Bytes head_str = frame.subspan(kPrefixBytes);
  if (length > head_str.size()) return PacketFault::kTruncated;
  if (length < head_str.size()) return PacketFault::kLength;
  if (length > static_cast<std::size_t>(std::numeric_limits<int>::max())) return PacketFault::kLength;
  return DecodeHead(head_str, head);
}

std::string PlainTopic(std::string_view channel) {
  std::string topic(channel);
  topic += kPlainMark;
  return topic;
}

std::string PeerTopic(std::string_view channel, SessionId session) {
  std::string topic(channel);
  topic += kPeerMark;
  topic += session.ToString();
  return topic;
}

std::optional<Topic> ParseTopic(Bytes frame) noexcept {
  const std::string_view text = AsText(frame);
  const auto named = [text](std::size_t length) -> std::optional<Topic> {
    // The marks 00 and 01 that end a channel's name are control characters, which names cannot have.
    if (!ChannelNameFault(text.substr(0, length)).empty()) return std::nullopt;
    return Topic{text.substr(0, length), {}};
  };
  if (text.ends_with(kPlainMark)) return named(text.size() - 1);
  if (text.size() <= kSessionDigits || text[text.size() - kSessionDigits - 1] != kPeerMark) return std::nullopt;
  const SessionId session = ReadSession(text.substr(text.size() - kSessionDigits));
  if (session == SessionId{}) return std::nullopt;
  std::optional<Topic> topic = named(text.size() - kSessionDigits - 1);
  if (topic) topic->session = session;
  return topic;
}

}  // namespace hgros
