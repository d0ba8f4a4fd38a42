#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/own_string.hpp"

namespace hgros {

/// Lets the library write a type without changing the type: specialize it next to the type's definition, before the
/// first use of the type as a message. It takes precedence over everything else that the type offers.
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
/// Optional: `static std::uint64_t Fingerprint()` (of the layout; the default 0 is never compared), `static std::size_t
/// MemoryBytes(const Scan&)` (default, also if it throws: sizeof), and `using Schema = SomeProtobufMessage;` if the
/// bytes are that protobuf message: name, fingerprint and schema are then those of the message, and the encoding is
/// kProtobuf.
///
/// Threading: all functions may be called from any thread. An exception counts as failure. If Serialize throws
/// std::bad_alloc, publishing returns kNoMemory. If Encode does, the message stays in its session, and this is counted
/// and logged.
template <class T>
struct CustomCodec;

/// There is a CustomCodec for T.
template <class T>
concept HasCustomCodec = requires {
  sizeof(CustomCodec<T>);
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
      try {
        return Codec::MemoryBytes(message);
      } catch (...) {  // Publishing goes on.
        return sizeof(T);
      }
    } else {
      return sizeof(T);
    }
  }

  static Payload EncodeCopy(const T& message) requires(!SharingCustomCodec<T>) {
    auto text = std::make_shared<std::string>();
    if (!Codec::Serialize(message, *text)) return {};
    return OwnString(std::move(text));
  }
  static Payload Encode(const std::shared_ptr<const T>& message) {
    if constexpr (SharingCustomCodec<T>) {
      return Codec::Encode(message);
    } else {
      return EncodeCopy(*message);
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

}  // namespace codec
}  // namespace hgros
