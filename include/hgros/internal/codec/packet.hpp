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

/// What a packet says about its cause; see Cause.
struct CauseHead {
  std::uint64_t message = 0;       ///< The key of the message that caused it; 0: it begins a chain.
  std::uint64_t chain_age_ns = 0;  ///< From the beginning of the chain to publish_time_ns.
  std::uint32_t chain_origin = 0;  ///< 0: its own channel.
  std::int64_t unsent = 0;         ///< Its number inside the publishing process less its sequence; for its own key.
  bool operator==(const CauseHead&) const = default;
};

/// The metadata of a packet. docs/wire-protocol.md is the specification.
struct PacketHead {
  std::string channel;
  std::string type_name;                    ///< Empty: unknown.
  Encoding encoding = Encoding::kProtobuf;  ///< After decoding, kNone means unknown.
  std::uint64_t fingerprint = 0;            ///< 0: unknown.
  MessageId id;                      ///< publisher 0: the sender does not count (another language, the paper's own).
  std::int64_t publish_time_ns = 0;  ///< Wall clock, ns since the Unix epoch; 0: unknown.
  std::uint32_t latched = 0;  ///< Number of messages that the publisher keeps on this channel for late subscribers.
  std::int64_t publish_monotonic_ns = 0;  ///< The sender's CLOCK_MONOTONIC; only meaningful on the same host.
  CauseHead cause;
};

/// Why a packet was refused. Each reason has its own counter.
enum class PacketFault : std::uint8_t {
  kNone,
  kTruncated,  ///< Shorter than its fields require, or a frame is missing.
  kSeparator,  ///< The separator is not 0x2424.
  kLength,     ///< header_length disagrees with the frame.
  kVersion,    ///< An unsupported major version.
  kHead,       ///< head_str is not a head message, or its channel is not a channel name.
  kTopic,      ///< The topic frame names another channel than the head.
  kType,       ///< Another type or an incompatible schema.
  kData,       ///< The data does not parse as the type.
  /// More than may be in flight (from a plain publisher that is too fast, or a session that exceeded its credit), or a
  /// message larger than the limit.
  kOverrun,
};
inline constexpr std::size_t kPacketFaultCount = 10;

/// One word for logs and tables, such as "truncated".
[[nodiscard]] HGROS_EXPORT std::string_view ToString(PacketFault fault) noexcept;

inline constexpr std::uint16_t kHeaderSeparator = 0x2424;
inline constexpr std::uint32_t kWireMajor = 1;  ///< Incremented when an older reader would misread.
inline constexpr std::uint32_t kWireMinor = 3;  ///< Incremented when fields are added that an older reader may skip.

/// Writes the head frame: header_length (u32 LE), header_separator (u16 LE), head_str.
/// Errors: none. `frame` is cleared first; its capacity is reused.
HGROS_EXPORT void EncodeHeadFrame(const PacketHead& head, std::string& frame);

/// Reads a head frame. On a fault the state of `head` is unspecified but valid. Never throws on bad input.
[[nodiscard]] HGROS_EXPORT PacketFault DecodeHeadFrame(Bytes frame, PacketHead& head);

/// Topics (first frame). Plain subscribers (any language) subscribe to `channel` + '\0' and get best effort. A
/// HyperGraph ROS session subscribes to `channel` + '\1' + its session id (16 hex digits) and grants credits.
[[nodiscard]] HGROS_EXPORT std::string PlainTopic(std::string_view channel);
[[nodiscard]] HGROS_EXPORT std::string PeerTopic(std::string_view channel, SessionId session);

struct Topic {
  std::string_view channel;
  SessionId session;  ///< None for a plain topic.
};
/// Splits a topic; empty if it has neither of the two forms.
[[nodiscard]] HGROS_EXPORT std::optional<Topic> ParseTopic(Bytes frame) noexcept;

}  // namespace hgros
