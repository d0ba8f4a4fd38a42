#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// What a packet says about its data. docs/wire-protocol.md is the specification.
struct PacketHead {
  std::string channel;
  std::string type_name;                    ///< Empty: the sender does not say.
  Encoding encoding = Encoding::kProtobuf;  ///< kNone after decoding: the sender does not say.
  std::uint64_t fingerprint = 0;            ///< 0: the sender does not know.
  MessageId id;                      ///< publisher 0: the sender does not count (another language, the paper's own).
  std::int64_t publish_time_ns = 0;  ///< Wall clock, ns since the Unix epoch; 0: unknown.
  std::uint32_t latched = 0;  ///< How many of its messages on this channel the publisher keeps for late subscribers.
  std::int64_t publish_monotonic_ns = 0;  ///< The sender's CLOCK_MONOTONIC; means something on the same host only.
};

/// Why a packet was refused. Each kind is counted apart.
enum class PacketFault : std::uint8_t {
  kNone,
  kTruncated,  ///< Shorter than its own fields say, or a frame is missing.
  kSeparator,  ///< The separator is not 0x2424.
  kLength,     ///< header_length disagrees with the frame.
  kVersion,    ///< A major version this library does not speak.
  kHead,       ///< head_str is not a head message, or its channel is not a channel name.
  kTopic,      ///< The topic frame names another channel than the head.
  kType,       ///< Another type or an incompatible schema.
  kData,       ///< The data does not parse as the type.
  /// More than may be in flight: a plain publisher that is too fast, or a session that overdrew its credit. Or a
  /// message that is larger than is taken here.
  kOverrun,
};
inline constexpr std::size_t kPacketFaultCount = 10;

/// One word for logs and tables, such as "truncated".
[[nodiscard]] HGROS_EXPORT std::string_view ToString(PacketFault fault) noexcept;

inline constexpr std::uint16_t kHeaderSeparator = 0x2424;
inline constexpr std::uint32_t kWireMajor = 1;  ///< Raised when an older reader would misread.
inline constexpr std::uint32_t kWireMinor = 1;  ///< Raised when fields are added that an older reader may skip.

/// Writes the head frame: header_length (u32 LE), header_separator (u16 LE), head_str.
/// Errors: none; appends nothing but the frame to `frame`, which is cleared first (its capacity is reused).
HGROS_EXPORT void EncodeHeadFrame(const PacketHead& head, std::string& frame);

/// Reads a head frame. On a fault `head` is left in an unspecified but valid state. Never throws on bad input.
[[nodiscard]] HGROS_EXPORT PacketFault DecodeHeadFrame(Bytes frame, PacketHead& head);

/// Topics (first frame). Plain subscribers (any language) subscribe to `channel` + '\0' and get best effort; a
/// HyperGraph ROS session subscribes to `channel` + '\1' + its session id (16 hex digits) and gets credits.
[[nodiscard]] HGROS_EXPORT std::string PlainTopic(std::string_view channel);
[[nodiscard]] HGROS_EXPORT std::string PeerTopic(std::string_view channel, SessionId session);

struct Topic {
  std::string_view channel;
  SessionId session;  ///< None for a plain topic.
};
/// Takes a topic apart; nothing if it is neither of the two forms.
[[nodiscard]] HGROS_EXPORT std::optional<Topic> ParseTopic(Bytes frame) noexcept;

}  // namespace hgros
