#include "hgros/codec/packet.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstring>
#include <limits>

#include "hgros/base/names.hpp"

// The head is written and read by hand: it goes before every message, the generated class costs several times as much
// and complains to standard error when a peer sends text that is not UTF-8. Tests compare the two on every input.
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
};

enum Wire : std::uint32_t { kVarint = 0, kFixed64 = 1, kLengthDelimited = 2, kStartGroup = 3, kFixed32 = 5 };

constexpr std::uint32_t Tag(Field field, Wire wire) { return (field << 3U) | wire; }

template <std::unsigned_integral T>
char* PutLittleEndian(char* at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) at[i] = static_cast<char>((value >> (8 * i)) & 0xffU);
  return at + sizeof(T);
}

template <std::unsigned_integral T>
T GetLittleEndian(const std::byte* at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value | (std::to_integer<T>(at[i]) << (8 * i)));
  return value;
}

char* PutVarint(char* at, std::uint64_t value) {
  while (value >= 0x80U) {
    *at++ = static_cast<char>(value | 0x80U);
    value >>= 7U;
  }
  *at++ = static_cast<char>(value);
  return at;
}

char* PutText(char* at, Field field, std::string_view text) {
  if (text.empty()) return at;
  *at++ = static_cast<char>(Tag(field, kLengthDelimited));
  at = PutVarint(at, text.size());
  std::memcpy(at, text.data(), text.size());
  return at + text.size();
}

char* PutFixed64(char* at, Field field, std::uint64_t value) {
  if (value == 0) return at;
  *at++ = static_cast<char>(Tag(field, kFixed64));
  return PutLittleEndian(at, value);
}

char* PutNumber(char* at, Field field, std::uint64_t value) {
  if (value == 0) return at;
  *at++ = static_cast<char>(Tag(field, kVarint));
  return PutVarint(at, value);
}

/// Reads protobuf wire format. Once something does not read, ok() stays false and every value is 0.
class FieldReader {
 public:
  explicit FieldReader(Bytes bytes) noexcept : rest_(bytes) {}

  [[nodiscard]] bool ok() const noexcept { return ok_; }
  [[nodiscard]] bool more() const noexcept { return ok_ && !rest_.empty(); }

  std::uint32_t ReadTag() noexcept { return static_cast<std::uint32_t>(ReadVarint(kMaxShortVarint)); }
  std::uint64_t ReadVarint() noexcept { return ReadVarint(kMaxVarint); }

  template <std::unsigned_integral T>
  T ReadFixed() noexcept {
    const Bytes bytes = Take(sizeof(T));
    return ok_ ? GetLittleEndian<T>(bytes.data()) : T{0};
  }

  std::string_view ReadText() noexcept { return AsText(Take(ReadVarint(kMaxShortVarint))); }

  void Skip(std::uint32_t tag) {
    switch (tag & 7U) {
      case kVarint: ReadVarint(); break;
      case kFixed64: Take(8); break;
      case kLengthDelimited: ReadText(); break;
      case kStartGroup: SkipGroup(tag); break;
      case kFixed32: Take(4); break;
      default: ok_ = false;
    }
    if ((tag >> 3U) == 0) ok_ = false;
  }

 private:
  static constexpr std::size_t kMaxVarint = 10;
  static constexpr std::size_t kMaxShortVarint = 5;  ///< Of tags and lengths.

  std::uint64_t ReadVarint(std::size_t max_bytes) noexcept {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < max_bytes && i < rest_.size(); ++i) {
      const auto byte = std::to_integer<std::uint64_t>(rest_[i]);
      value |= (byte & 0x7fU) << (7 * i);
      if (byte < 0x80U) {
        rest_ = rest_.subspan(i + 1);
        return value;
      }
    }
    ok_ = false;
    return 0;
  }

  Bytes Take(std::uint64_t size) noexcept {
    ok_ = ok_ && size <= rest_.size();
    if (!ok_) return {};
    const Bytes taken = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }

  /// Groups nest and are nobody's habit any more: left to protobuf, which also limits their depth.
  void SkipGroup(std::uint32_t tag) {
    using google::protobuf::internal::WireFormatLite;
    google::protobuf::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(rest_.data()),
                                              static_cast<int>(rest_.size()));
    ok_ = WireFormatLite::SkipField(&in, tag);
    if (ok_) Take(static_cast<std::uint64_t>(in.CurrentPosition()));
  }

  Bytes rest_;
  bool ok_ = true;
};

/// What a head says besides a PacketHead.
struct Preamble {
  std::uint32_t version = 0;
  std::uint32_t encoding = 0;
};

/// Reads one field. What is unknown, or of another wire type than ours, is skipped, as every protobuf reader does.
void ReadField(FieldReader& in, PacketHead& head, Preamble& preamble) {
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
    default: in.Skip(tag);
  }
}

PacketFault DecodeHead(Bytes head_str, PacketHead& head) {
  FieldReader in(head_str);
  Preamble preamble;
  while (in.more()) ReadField(in, head, preamble);
  // The version goes first: what another major version means by the rest is not ours to judge.
  if (preamble.version != 0 && (preamble.version >> 16U) != kWireMajor) return PacketFault::kVersion;
  if (!in.ok() || !ChannelNameFault(head.channel).empty()) return PacketFault::kHead;
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
}

/// The number that 16 lower-case hexadecimal digits stand for; a second spelling would be a second topic.
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
  // Tags, a fixed32, five fixed64, three varints and two text lengths take less than this.
  constexpr std::size_t kMaxFixedPart = 128;
  frame.resize(kPrefixBytes + kMaxFixedPart + head.channel.size() + head.type_name.size());
  char* const begin = frame.data();
  char* at = begin + kPrefixBytes;
  *at++ = static_cast<char>(Tag(kVersion, kFixed32));
  at = PutLittleEndian(at, (kWireMajor << 16U) | kWireMinor);
  at = PutText(at, kChannel, head.channel);
  at = PutText(at, kType, head.type_name);
  at = PutNumber(at, kEncoding, static_cast<std::uint64_t>(head.encoding));
  at = PutFixed64(at, kFingerprint, head.fingerprint);
  at = PutFixed64(at, kPublisherId, head.id.publisher);
  at = PutFixed64(at, kIncarnation, head.id.incarnation);
  at = PutNumber(at, kSequence, head.id.sequence);
  at = PutFixed64(at, kPublishTime, static_cast<std::uint64_t>(head.publish_time_ns));
  at = PutFixed64(at, kPublishMonotonic, static_cast<std::uint64_t>(head.publish_monotonic_ns));
  at = PutNumber(at, kLatched, head.latched);
  const auto size = static_cast<std::size_t>(at - begin);
  PutLittleEndian(begin, static_cast<std::uint32_t>(size - kPrefixBytes));
  PutLittleEndian(begin + 4, kHeaderSeparator);
  frame.resize(size);
}

PacketFault DecodeHeadFrame(Bytes frame, PacketHead& head) {
  Clear(head);
  if (frame.size() < kPrefixBytes) return PacketFault::kTruncated;
  if (GetLittleEndian<std::uint16_t>(frame.data() + 4) != kHeaderSeparator) return PacketFault::kSeparator;
  const std::size_t length = GetLittleEndian<std::uint32_t>(frame.data());
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
    // Names have no control characters, so that a mark in another place is a fault of the name.
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
