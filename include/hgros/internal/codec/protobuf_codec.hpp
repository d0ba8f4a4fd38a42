#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/codec/type_info.hpp"

namespace google::protobuf {
class Message;
}

namespace hgros {

/// T is a generated protobuf class (not the abstract Message, and not DynamicMessage, whose type is known only at
/// run time).
template <class T>
concept ProtobufMessage = std::is_class_v<T> && std::is_base_of_v<google::protobuf::Message, T> && requires {
  T::descriptor();
};

namespace codec {

template <class T>
struct ProtobufTraits {
  static constexpr Encoding kEncoding = Encoding::kProtobuf;
  static constexpr std::size_t kMaxBytes = std::numeric_limits<int>::max();  ///< protobuf's own limit.

  static std::string Name() { return SchemaName(*T::descriptor()); }
  static std::uint64_t LayoutFingerprint() { return SchemaFingerprint(*T::descriptor()); }
  static std::size_t MemoryBytes(const T& message) { return message.SpaceUsedLong(); }

  static std::size_t EncodedBytes(const T& message) { return message.ByteSizeLong(); }
  /// Call EncodedBytes() first: it computes the sizes of nested messages. The message must not change in between; if
  /// its size has changed, it is not written.
  static bool EncodeInto(const T& message, std::span<std::byte> bytes) {
    if (bytes.size() > kMaxBytes || !message.IsInitialized()) return false;
    if (static_cast<std::size_t>(message.GetCachedSize()) != bytes.size()) return false;
    message.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data()));
    return true;
  }

  static Payload Encode(const std::shared_ptr<const T>& message) {
    const std::size_t size = EncodedBytes(*message);
    if (size > kMaxBytes) return {};
    std::shared_ptr<std::byte[]> buffer = std::make_shared_for_overwrite<std::byte[]>(size);
    const std::span<std::byte> bytes(buffer.get(), size);
    if (!EncodeInto(*message, bytes)) return {};
    return {bytes, std::move(buffer)};
  }

  static std::shared_ptr<const T> Decode(const Payload& payload) {
    if (payload.bytes.size() > kMaxBytes) return nullptr;
    auto message = std::make_shared<T>();
    // ParseFromArray would log missing fields. Here the caller counts the failure instead.
    if (!message->ParsePartialFromArray(payload.bytes.data(), static_cast<int>(payload.bytes.size()))) return nullptr;
    if (!message->IsInitialized()) return nullptr;
    return message;
  }
};

}  // namespace codec
}  // namespace hgros
