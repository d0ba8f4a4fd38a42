#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <typeinfo>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/fingerprint.hpp"
#include "hgros/internal/codec/plain_layout.hpp"
#include "hgros/internal/codec/type_name.hpp"

namespace hgros {

/// T is sent as its bytes: arithmetic types, enums, and trivially copyable aggregates of these (including arrays and
/// structs). A struct with a visible pointer, reference or class with constructors is refused, because its bytes mean
/// nothing elsewhere; kPlainValue allows a class with constructors.
///
/// Sender and receiver need equal layouts and byte orders, which the fingerprint checks. It does not include field
/// names or widths of bit fields: rename a struct when its meaning changes. Padding bytes are sent unchanged.
template <class T>
concept PlainStruct = std::is_object_v<T> && !std::is_array_v<T> && codec::IsPlain<std::remove_cv_t<T>>();

namespace codec {

template <class T>
struct PlainTraits {
  static constexpr Encoding kEncoding = Encoding::kPlain;
  /// A received struct of this size or more is viewed in the payload. A smaller one is copied, so that it does not keep
  /// a large buffer alive.
  static constexpr std::size_t kSharedFrom = 1024;

  static std::string Name() { return CppTypeName(typeid(T)); }

  static std::uint64_t LayoutFingerprint() {
    static_assert(std::endian::native == std::endian::little || std::endian::native == std::endian::big);
    const char* const order = std::endian::native == std::endian::little ? "little" : "big";
    return Fingerprint("plain 1\n" + Name() + "\n" + order + "\n" + std::to_string(sizeof(T)) + " " +
                       std::to_string(alignof(T)) + "\n" + LayoutText<T>() + "\n");
  }

  static std::size_t MemoryBytes(const T&) { return sizeof(T); }

  static Payload Encode(const std::shared_ptr<const T>& message) {
    return {std::as_bytes(std::span<const T, 1>(message.get(), 1)), message};
  }

  static std::shared_ptr<const T> Decode(const Payload& payload) {
    if (payload.bytes.size() != sizeof(T)) return nullptr;
    const std::byte* const bytes = payload.bytes.data();
    if (sizeof(T) >= kSharedFrom && payload.owner && reinterpret_cast<std::uintptr_t>(bytes) % alignof(T) == 0) {
      return {payload.owner, reinterpret_cast<const T*>(bytes)};
    }
    auto message = std::make_shared_for_overwrite<T>();
    std::memcpy(static_cast<void*>(message.get()), bytes, sizeof(T));
    return message;
  }
};

}  // namespace codec
}  // namespace hgros
