#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/control.pb.h"
#include "hgros/transport/transport.hpp"

namespace hgros::zmq {

/// First byte of a control topic, and of every control message that goes upstream. ZeroMQ takes 0 and 1 there for
/// subscriptions; everything else passes as a message.
inline constexpr char kControlByte = '\x02';
/// Larger control messages are refused; a descriptor set is the largest part of one.
inline constexpr std::size_t kMaxControlBytes = 4u << 20;
/// Likewise upstream: the largest there is a Subscribe with a long type name. ZeroMQ closes the connection for more.
inline constexpr std::size_t kMaxUpstreamBytes = 64u << 10;
/// The longest type name that can be asked for.
inline constexpr std::size_t kMaxTypeNameBytes = 1024;
/// The longest text for people in a control message; a longer one is cut.
inline constexpr std::size_t kMaxTextBytes = 512;

/// What a session says of itself in its handshakes.
struct SessionFacts {
  PeerInfo info;
  std::uint64_t incarnation = 0;
};

/// A peer's text, fit for a line of a log: not too long, without control characters.
[[nodiscard]] std::string Readable(const std::string& text);

[[nodiscard]] std::string ControlTopic(SessionId session);
[[nodiscard]] std::optional<SessionId> ParseControlTopic(std::string_view topic) noexcept;

/// A data packet's first frame. A peer's copy carries 8 bytes more than what the peer subscribed to: the message's
/// number on the link, u64 little-endian.
struct DataTopic {
  std::string_view channel;
  SessionId session;         ///< None for a plain topic.
  std::uint64_t number = 0;  ///< On the link; 0 for a plain topic.
};
[[nodiscard]] std::optional<DataTopic> ParseDataTopic(Bytes frame) noexcept;
/// Overwrites the last 8 bytes of `topic`.
void WriteLinkNumber(std::string& topic, std::uint64_t number) noexcept;

[[nodiscard]] std::optional<wire::Control> ParseControl(Bytes bytes);
[[nodiscard]] wire::Control ControlFrom(SessionId session);
/// An upstream message: kControlByte and the control message.
[[nodiscard]] std::string UpstreamFrame(const wire::Control& control);

void WriteFacts(const SessionFacts& facts, wire::SessionFacts& to);
[[nodiscard]] SessionFacts ReadFacts(SessionId session, const wire::SessionFacts& from);

void WriteType(std::string_view channel, const TypeInfo& type, wire::ChannelType& to);

/// Whether what one side publishes can be what the other side reads.
enum class TypeFit {
  kEqual,    ///< As far as both know.
  kEvolved,  ///< One protobuf type name, two schemas: they must be compared.
  kDiffer,
};
[[nodiscard]] TypeFit CompareTypes(const wire::ChannelType& theirs, const TypeInfo& ours) noexcept;
/// "channel scan: here foo.Scan (protobuf, 0x12), there foo.Image (protobuf, 0x34)".
[[nodiscard]] std::string DescribeMismatch(const wire::ChannelType& theirs, const TypeInfo& ours);

/// Compares our protobuf type with the peer's of the same name. An empty text: compatible.
[[nodiscard]] std::string SchemaFault(const std::string& their_descriptor_set, const TypeInfo& ours);

}  // namespace hgros::zmq
