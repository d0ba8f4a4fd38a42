#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// What a publisher says of the messages that it sends on a channel.
struct MessageSchema {
  std::string type_name;  ///< Empty: it does not say, as plain ZeroMQ programs need not.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown, or there is none.
  /// For a protobuf type: a serialized google.protobuf.FileDescriptorSet with all imports, dependencies first. A schema
  /// from another session may contain anything; DynamicSchema reads it safely. Empty: there is none.
  std::string descriptor_set;

  bool operator==(const MessageSchema&) const = default;
};

/// A message of a type that the program need not know: its bytes as they came, or, of a message of this process, as
/// they would be sent.
struct RawMessage {
  std::shared_ptr<const MessageSchema> schema;  ///< One object for all messages of one publisher; never null.
  Payload data;                                 ///< Shared with the transport, not copied.
};

/// Stands for whatever type a channel has: who wants messages as this gets each as a RawMessage. It fixes no channel's
/// type, and has no name on the wire.
[[nodiscard]] HGROS_EXPORT const TypeInfo& AnyType() noexcept;
[[nodiscard]] inline bool IsAnyType(const TypeInfo& type) noexcept { return type.any; }

/// What this program sends of that type.
[[nodiscard]] HGROS_EXPORT MessageSchema SchemaOf(const TypeInfo& type);

/// Why messages of `theirs` cannot be read as `ours`; empty if they can. Evolved protobuf schemas are compared, which
/// takes from 0.1 ms up: once per publisher and channel, never per message.
[[nodiscard]] HGROS_EXPORT std::string MisfitOf(const MessageSchema& theirs, const TypeInfo& ours);

}  // namespace hgros
