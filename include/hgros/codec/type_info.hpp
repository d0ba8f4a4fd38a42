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

/// A message whose C++ type is known to the channel that carries it, not to the code that passes it on. Made and
/// read only by typed code that has compared type indices once, when publisher and subscription were wired.
using AnyMessage = std::shared_ptr<const void>;

/// How a type is written on the wire.
enum class Encoding : std::uint8_t {
  kNone = 0,      ///< Not at all: the type stays inside one process.
  kProtobuf = 1,  ///< A generated protobuf class.
  kCustom = 2,    ///< The type's own SerializeToString / ParseFromString, or a CustomCodec.
  kPlain = 3,     ///< The bytes of a trivially copyable struct; only between equal layouts and byte orders.
};

/// What the graph and the transports know of one C++ type. Lives as long as the program, but a shared library may have
/// its own copy for the same type: compare cpp_type, never addresses.
/// Thread-safe: every function may be called from any thread. None throws.
struct TypeInfo {
  std::string name;  ///< The wire's name: the protobuf full name, or a custom or C++ type's own.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< Of the schema or layout; 0 where a type has none (custom codecs, kNone).
  std::type_index cpp_type = typeid(void);

  /// Stands for any type: see AnyType().
  bool any = false;
  /// The schema of a type that the program names at run time: see RunTimeType(). Null for a C++ type.
  const RunTimeSchema* run_time = nullptr;
  /// The functions below run code of the user's, which has no place on a thread that owns a socket.
  bool users_codec = false;

  /// Memory a queued message takes, in bytes, roughly: for queues with a byte limit.
  std::size_t (*memory_bytes)(const void* message) = nullptr;
  /// Writes the message, or shows its bytes in place where the type is one block (then the payload shares the
  /// message). A payload without an owner means that the message cannot be written. Null for kNone.
  Payload (*encode)(const AnyMessage& message) = nullptr;
  /// The same in two steps, into memory of the caller's, such as a block that the receivers will read: how many bytes,
  /// and then writing exactly so many; false: it cannot be written. Both null where a type is written by encode alone.
  std::size_t (*encoded_bytes)(const void* message) = nullptr;
  bool (*encode_into)(const void* message, std::span<std::byte> bytes) = nullptr;
  /// Shows the bytes of the whole message in the memory of its large part. Without owner: they do not lie so, and the
  /// other functions copy them. Null where a type knows nothing of the kind.
  Payload (*encode_in_place)(const void* message) = nullptr;
  /// Reads a message; may keep sharing the payload instead of copying. Null if the bytes are not such a message.
  /// Null for kNone.
  AnyMessage (*decode)(const Payload& payload) = nullptr;

  /// Another C++ type with the same wire form, and how a message of this type becomes one of that, and back: the
  /// results may share the argument, and are null if that is not possible. Null where there is no other.
  std::type_index other_cpp_type = typeid(void);
  AnyMessage (*to_other)(const AnyMessage& message) = nullptr;
  AnyMessage (*from_other)(const AnyMessage& message) = nullptr;

  /// A serialized google.protobuf.FileDescriptorSet with all imports, dependencies first. Null where there is none.
  std::string (*descriptor_set)() = nullptr;
  /// The schema of a protobuf type, for CheckSchemas. Null where there is none.
  const google::protobuf::Descriptor* (*descriptor)() = nullptr;
};

/// Whether messages of both are the same C++ objects.
[[nodiscard]] inline bool IsSameType(const TypeInfo& one, const TypeInfo& other) noexcept {
  return one.cpp_type == other.cpp_type && one.run_time == other.run_time;
}

}  // namespace hgros
