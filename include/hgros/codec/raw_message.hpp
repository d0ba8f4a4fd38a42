#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// The type of a publisher's messages on a channel, as the publisher describes it.
struct MessageSchema {
  std::string type_name;  ///< Empty: unknown. Plain ZeroMQ programs need not send it.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown or none.
  /// For a protobuf type: a serialized google.protobuf.FileDescriptorSet with all imports, dependencies first. A schema
  /// from another session may contain anything; DynamicSchema reads it safely. Empty: none.
  std::string descriptor_set;

  bool operator==(const MessageSchema&) const = default;
};

/// A message as bytes, whatever its type. From another process: the bytes as they arrived. From this process: the bytes
/// as they would be sent.
struct RawMessage {
  std::shared_ptr<const MessageSchema> schema;  ///< One object for all messages of one publisher; never null.
  Payload data;                                 ///< Shared with the transport, not copied.
};

/// Stands for any type. A subscription with this type gets each message as a RawMessage. It does not fix the type of a
/// channel and has no name on the wire.
[[nodiscard]] HGROS_EXPORT const TypeInfo& AnyType() noexcept;
[[nodiscard]] inline bool IsAnyType(const TypeInfo& type) noexcept { return type.any; }

/// The schema that this program sends for messages of that type.
[[nodiscard]] HGROS_EXPORT MessageSchema SchemaOf(const TypeInfo& type);

/// Why messages of `theirs` cannot be read as `ours`; empty if they can. Comparing evolved protobuf schemas takes 0.1
/// ms or more: call it once per publisher and channel, never per message.
[[nodiscard]] HGROS_EXPORT std::string MisfitOf(const MessageSchema& theirs, const TypeInfo& ours);

}  // namespace hgros
