#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <typeinfo>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/own_string.hpp"
#include "hgros/internal/codec/type_name.hpp"

namespace hgros {

/// T writes and reads itself through the two methods of the paper (section "network_bridge"). Its name on the wire is
/// T::kTypeName if there is one, else its C++ name.
template <class T>
concept SerializesItself = std::default_initializable<T> &&
    requires(const T& written, T& read, std::string* out, const std::string& in) {
  { written.SerializeToString(out) } -> std::convertible_to<bool>;
  { read.ParseFromString(in) } -> std::convertible_to<bool>;
};

namespace codec {

template <class T>
struct SelfTraits {
  static constexpr Encoding kEncoding = Encoding::kCustom;

  static std::string Name() {
    if constexpr (requires { std::string(T::kTypeName); }) {
      return std::string(T::kTypeName);
    } else {
      return CppTypeName(typeid(T));
    }
  }

  static std::uint64_t LayoutFingerprint() { return 0; }
  static std::size_t MemoryBytes(const T&) { return sizeof(T); }

  static Payload EncodeCopy(const T& message) {
    auto text = std::make_shared<std::string>();
    if (!message.SerializeToString(text.get())) return {};
    return OwnString(std::move(text));
  }
  static Payload Encode(const std::shared_ptr<const T>& message) { return EncodeCopy(*message); }

  static std::shared_ptr<const T> Decode(const Payload& payload) {
    auto message = std::make_shared<T>();
    // A method that takes a string_view saves copying all bytes.
    if constexpr (requires { message->ParseFromString(AsText(payload.bytes)); }) {
      if (!message->ParseFromString(AsText(payload.bytes))) return nullptr;
    } else {
      if (!message->ParseFromString(std::string(AsText(payload.bytes)))) return nullptr;
    }
    return message;
  }
};

}  // namespace codec
}  // namespace hgros
