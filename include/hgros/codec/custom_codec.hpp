#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/codec/type_name.hpp"

namespace hgros {

/// Teaches the library to write a type without touching the type: specialize it beside the type's definition, before
/// the first use of the type as a message. It goes before everything else that a type may offer.
///
///     template <>
///     struct hgros::CustomCodec<Scan> {
///       static constexpr std::string_view kTypeName = "lidar.Scan";    // or static std::string TypeName()
///       static bool Serialize(const Scan& scan, std::string& bytes);   // false: cannot be written
///       static bool Parse(std::string_view bytes, Scan& scan);         // false: not a scan
///     };
///
/// Instead of Serialize and Parse, without copies:
///
///       static Payload Encode(const std::shared_ptr<const Scan>& scan);          // no owner: cannot be written
///       static std::shared_ptr<const Scan> Decode(const Payload& payload);       // null: not a scan
///
/// Optional: `static std::uint64_t Fingerprint()` (of the layout; 0, the default, is never compared),
/// `static std::size_t MemoryBytes(const Scan&)` (default: sizeof), and `using Schema = SomeProtobufMessage;` where
/// the bytes are that protobuf message: then name, fingerprint and schema are the message's and need not be given,
/// and the encoding is kProtobuf.
///
/// Threading: all functions may be called from any thread. An exception counts as failure.
template <class T>
struct CustomCodec;

/// There is a CustomCodec for T.
template <class T>
concept HasCustomCodec = requires {
  sizeof(CustomCodec<T>);
};

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
concept CopyingCustomCodec = std::default_initializable<T> &&
    requires(const T& from, T& to, std::string& out, std::string_view in) {
  { CustomCodec<T>::Serialize(from, out) } -> std::convertible_to<bool>;
  { CustomCodec<T>::Parse(in, to) } -> std::convertible_to<bool>;
};

template <class T>
concept SharingCustomCodec = requires(const std::shared_ptr<const T>& message, const Payload& payload) {
  { CustomCodec<T>::Encode(message) } -> std::convertible_to<Payload>;
  { CustomCodec<T>::Decode(payload) } -> std::convertible_to<std::shared_ptr<const T>>;
};

template <class T>
concept CustomCodecWithSchema = requires {
  CustomCodec<T>::Schema::descriptor();
};

/// Hands a string over as a payload that owns it.
inline Payload OwnString(std::shared_ptr<const std::string> text) {
  const Bytes bytes = AsBytes(*text);
  return {bytes, std::move(text)};
}

template <class T>
struct CustomTraits {
  using Codec = CustomCodec<T>;
  static_assert(CopyingCustomCodec<T> || SharingCustomCodec<T>,
                "CustomCodec<T> needs Serialize and Parse (with T default-constructible), or Encode and Decode");

  static constexpr Encoding kEncoding = CustomCodecWithSchema<T> ? Encoding::kProtobuf : Encoding::kCustom;

  static std::string Name() {
    if constexpr (CustomCodecWithSchema<T>) {
      return SchemaName(*Codec::Schema::descriptor());
    } else if constexpr (requires { std::string(Codec::kTypeName); }) {
      return std::string(Codec::kTypeName);
    } else {
      static_assert(
          requires { std::string(Codec::TypeName()); }, "CustomCodec<T> needs kTypeName or TypeName()");
      return std::string(Codec::TypeName());
    }
  }

  static std::uint64_t LayoutFingerprint() {
    if constexpr (requires {
                    { Codec::Fingerprint() } -> std::convertible_to<std::uint64_t>;
                  }) {
      return Codec::Fingerprint();
    } else if constexpr (CustomCodecWithSchema<T>) {
      return SchemaFingerprint(*Codec::Schema::descriptor());
    } else {
      return 0;
    }
  }

  static std::size_t MemoryBytes(const T& message) {
    if constexpr (requires {
                    { Codec::MemoryBytes(message) } -> std::convertible_to<std::size_t>;
                  }) {
      return Codec::MemoryBytes(message);
    } else {
      return sizeof(T);
    }
  }

  static Payload Encode(const std::shared_ptr<const T>& message) {
    if constexpr (SharingCustomCodec<T>) {
      return Codec::Encode(message);
    } else {
      auto text = std::make_shared<std::string>();
      if (!Codec::Serialize(*message, *text)) return {};
      return OwnString(std::move(text));
    }
  }

  static std::shared_ptr<const T> Decode(const Payload& payload) {
    if constexpr (SharingCustomCodec<T>) {
      return Codec::Decode(payload);
    } else {
      auto message = std::make_shared<T>();
      if (!Codec::Parse(AsText(payload.bytes), *message)) return nullptr;
      return message;
    }
  }
};

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

  static Payload Encode(const std::shared_ptr<const T>& message) {
    auto text = std::make_shared<std::string>();
    if (!message->SerializeToString(text.get())) return {};
    return OwnString(std::move(text));
  }

  static std::shared_ptr<const T> Decode(const Payload& payload) {
    auto message = std::make_shared<T>();
    // A method that takes a string_view spares the copy of all bytes.
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
