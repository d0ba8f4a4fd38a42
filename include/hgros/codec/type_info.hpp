#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <typeindex>

#include "hgros/base/bytes.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace hgros {

struct RunTimeSchema;

/// A message whose C++ type is known to its channel, but not to the code that passes it on. It is created and read only
/// by typed code, which compared the type indices once, when publisher and subscription were wired.
using AnyMessage = std::shared_ptr<const void>;

/// How a type is written on the wire.
enum class Encoding : std::uint8_t {
  kNone = 0,      ///< Not written: the type stays inside one process.
  kProtobuf = 1,  ///< A generated protobuf class.
  kCustom = 2,    ///< The type's own SerializeToString / ParseFromString, or a CustomCodec.
  kPlain = 3,     ///< The bytes of a trivially copyable struct; only between equal layouts and byte orders.
};

/// The graph's and the transports' description of one C++ type. Lives as long as the program. A shared library may have
/// its own copy for the same type: compare cpp_type, never addresses. Thread-safe: every function may be called from
/// any thread. None throws, except that `encode` and `encode_copy` throw std::bad_alloc if there is no memory.
struct TypeInfo {
  std::string name;  ///< The name on the wire: the protobuf full name, or the name of the custom or C++ type.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< Identifies the schema or layout; 0 if there is none (custom codecs, kNone).
  std::type_index cpp_type = typeid(void);

  /// True only for AnyType().
  bool any = false;
  /// The schema of a type that the program names at run time; see RunTimeType(). Null for a C++ type.
  const RunTimeSchema* run_time = nullptr;
  /// The functions below run user code, which must not run on a thread that owns a socket.
  bool users_codec = false;

  /// Approximate memory of a queued message in bytes, for queues with a byte limit.
  std::size_t (*memory_bytes)(const void* message) = nullptr;
  /// Writes the message. If the type is one block of bytes, the payload shares the message instead. A payload without
  /// an owner means that the message cannot be written. Null for kNone.
  Payload (*encode)(const AnyMessage& message) = nullptr;
  /// The same in two steps, into the caller's memory, such as a block that the receivers will read. encoded_bytes
  /// returns the size, then encode_into writes exactly this number of bytes; false: the message cannot be written. Both
  /// are null if the type is written by encode alone.
  std::size_t (*encoded_bytes)(const void* message) = nullptr;
  bool (*encode_into)(const void* message, std::span<std::byte> bytes) = nullptr;
  /// Returns the bytes of the whole message in the memory of its large part. Without an owner: they are not contiguous
  /// there, and the other functions copy them. Null if the type has no large part.
  Payload (*encode_in_place)(const void* message) = nullptr;
  /// The large part itself. Null if the type has none.
  Bytes (*large_part)(const void* message) = nullptr;
  /// As `encode`, into memory of its own: for a user's codec that gets no pointer to the message that it could keep.
  /// Null for other types.
  Payload (*encode_copy)(const void* message) = nullptr;
  /// Reads a message. It may share the payload instead of copying it. Returns null if the bytes are not such a message.
  /// Null for kNone.
  AnyMessage (*decode)(const Payload& payload) = nullptr;

  /// Another C++ type with the same wire form, and functions that convert a message to it and back. The results may
  /// share the argument; they are null if that is not possible. typeid(void) and null if there is no other type.
  std::type_index other_cpp_type = typeid(void);
  AnyMessage (*to_other)(const AnyMessage& message) = nullptr;
  AnyMessage (*from_other)(const AnyMessage& message) = nullptr;

  /// A serialized google.protobuf.FileDescriptorSet with all imports, dependencies first. Null if there is none.
  std::string (*descriptor_set)() = nullptr;
  /// The schema of a protobuf type, for CheckSchemas. Null if there is none.
  const google::protobuf::Descriptor* (*descriptor)() = nullptr;
};

/// Whether messages of both types are the same C++ objects.
[[nodiscard]] inline bool IsSameType(const TypeInfo& one, const TypeInfo& other) noexcept {
  return one.cpp_type == other.cpp_type && one.run_time == other.run_time;
}

}  // namespace hgros
