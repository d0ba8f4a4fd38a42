#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/control.pb.h"
#include "hgros/internal/codec/channel_use.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

// The facts that two sessions exchange about themselves and their types, and how these are compared: the same for all
// transports.

/// Channels that one session can receive from another over one transport. It also limits the memory that a peer can
/// take.
inline constexpr std::size_t kMaxChannels = 16384;
/// Sessions of this minor version and later get Offers when channels come and go.
inline constexpr std::uint32_t kOffersSinceMinor = 1;
/// The longest displayed text in a control message. A longer one is cut.
inline constexpr std::size_t kMaxTextBytes = 512;

/// The facts of a session in its handshakes.
struct SessionFacts {
  PeerInfo info;
  std::uint64_t incarnation = 0;
  std::uint32_t wire_minor = 0;
};

void WriteFacts(const SessionFacts& facts, wire::SessionFacts& to);
[[nodiscard]] SessionFacts ReadFacts(SessionId session, const wire::SessionFacts& from);

/// AnyType() is written as no type at all.
void WriteType(std::string_view channel, const TypeInfo& type, wire::ChannelType& to);

/// Reads a peer's data about a channel that it uses; nullopt if the channel's name is invalid.
[[nodiscard]] std::optional<ChannelUse> ReadUse(const wire::ChannelType& from);

/// Whether the type that one side publishes fits the type that the other side reads.
enum class TypeFit {
  kEqual,    ///< As far as both sides know.
  kEvolved,  ///< One protobuf type name, two schemas: they must be compared.
  kDiffer,
};
[[nodiscard]] TypeFit CompareTypes(const wire::ChannelType& theirs, const TypeInfo& ours) noexcept;
/// "scan: lidar:12 publishes foo.Scan, view:34 subscribes to foo.Image": the same text on both sides. If the names are
/// equal, encodings and fingerprints follow them.
[[nodiscard]] std::string DescribeMismatch(const wire::ChannelType& theirs, const PeerInfo& peer, const TypeInfo& ours,
                                           const PeerInfo& self, bool peer_publishes);

/// Compares our protobuf type with the peer's of the same name. An empty text: compatible.
[[nodiscard]] std::string SchemaFault(const std::string& their_descriptor_set, const TypeInfo& ours);

/// The facts of a session of this process.
[[nodiscard]] SessionFacts OwnFacts(SessionId session, const std::string& process);

/// The schema that the publisher `from` has sent. A descriptor set of more than 1 MiB is left out, and the log says so.
[[nodiscard]] std::shared_ptr<const MessageSchema> ReadSchema(const wire::ChannelType& offered,
                                                              const std::string& descriptor_set, const PeerInfo& from,
                                                              Log& log);

/// The schema for a subscriber that has another version of the type, or accepts any; empty if the types are equal,
/// nullopt if they differ.
[[nodiscard]] std::optional<std::string> SchemaFor(const wire::ChannelType& wanted, const TypeInfo& type);

/// The name that allows the channel in an endpoint's list of channels. This is the channel's own name; for replies to
/// a caller (hgros/reply/ID/NAME) it is the name of the requests (hgros/call/NAME).
[[nodiscard]] std::string ListedAs(const std::string& channel);

/// Logs that the session subscribes to more than kMaxChannels, and that `channel` is therefore not received from
/// `peer`.
void LogTooManyChannels(Log& log, const PeerInfo& peer, const std::string& channel, std::string_view transport);

/// Throws Error if the type's name is longer than kMaxTypeNameBytes, or no readable text.
void RequireTypeName(const TypeInfo& type);

}  // namespace hgros
