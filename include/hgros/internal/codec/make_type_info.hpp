#pragma once

#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <typeinfo>

#include "hgros/codec/bulk.hpp"
#include "hgros/codec/custom_codec.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/bulk_codec.hpp"
#include "hgros/internal/codec/plain_codec.hpp"
#include "hgros/internal/codec/protobuf_codec.hpp"
#include "hgros/internal/codec/self_codec.hpp"
#include "hgros/internal/codec/type_name.hpp"

namespace hgros::codec {

/// A type that stays inside one process.
template <class T>
struct LocalTraits {
  static constexpr Encoding kEncoding = Encoding::kNone;
  static std::string Name() { return CppTypeName(typeid(T)); }
  static std::uint64_t LayoutFingerprint() { return 0; }
  static std::size_t MemoryBytes(const T&) { return sizeof(T); }
};

/// Selects how T is written: the first that fits.
template <class T>
consteval auto ChooseTraits() {
  if constexpr (HasCustomCodec<T>) {
    return std::type_identity<CustomTraits<T>>{};
  } else if constexpr (kIsBulk<T>) {
    return std::type_identity<BulkTraits<T>>{};
  } else if constexpr (ProtobufMessage<T>) {
    return std::type_identity<ProtobufTraits<T>>{};
  } else if constexpr (SerializesItself<T>) {
    return std::type_identity<SelfTraits<T>>{};
  } else if constexpr (PlainStruct<T>) {
    return std::type_identity<PlainTraits<T>>{};
  } else {
    return std::type_identity<LocalTraits<T>>{};
  }
}

template <class T>
using Traits = typename decltype(ChooseTraits<T>())::type;

template <class T>
struct SchemaOf {};
template <ProtobufMessage T>
requires(!HasCustomCodec<T>) struct SchemaOf<T> {
  static const google::protobuf::Descriptor* Get() { return T::descriptor(); }
};
template <class T>
struct SchemaOf<Bulk<T>> {
  static const google::protobuf::Descriptor* Get() { return T::descriptor(); }
};
template <CustomCodecWithSchema T>
struct SchemaOf<T> {
  static const google::protobuf::Descriptor* Get() { return CustomCodec<T>::Schema::descriptor(); }
};

template <class T>
TypeInfo MakeTypeInfo() {
  using TraitsOfT = Traits<T>;
  TypeInfo info;
  info.name = TraitsOfT::Name();
  info.encoding = TraitsOfT::kEncoding;
  info.fingerprint = TraitsOfT::LayoutFingerprint();
  info.cpp_type = typeid(T);
  info.users_codec = HasCustomCodec<T> || TraitsOfT::kEncoding == Encoding::kCustom;
  info.memory_bytes = [](const void* message) { return TraitsOfT::MemoryBytes(*static_cast<const T*>(message)); };
  if constexpr (TraitsOfT::kEncoding != Encoding::kNone) {
    // A codec that throws has failed to write or read one message, which the caller counts.
    if constexpr (requires(const T& message) { TraitsOfT::EncodeCopy(message); }) {
      info.encode_copy = [](const void* message) -> Payload {
        try {
          return TraitsOfT::EncodeCopy(*static_cast<const T*>(message));
        } catch (const std::bad_alloc&) {
          throw;
        } catch (...) {
          return {};
        }
      };
    }
    info.encode = [](const AnyMessage& message) -> Payload {
      try {
        return TraitsOfT::Encode(std::static_pointer_cast<const T>(message));
      } catch (const std::bad_alloc&) {
        throw;
      } catch (...) {
        return {};
      }
    };
    if constexpr (requires(const T& message, std::span<std::byte> bytes) {
                    TraitsOfT::EncodedBytes(message);
                    TraitsOfT::EncodeInto(message, bytes);
                  }) {
      info.encoded_bytes = [](const void* message) { return TraitsOfT::EncodedBytes(*static_cast<const T*>(message)); };
      info.encode_into = [](const void* message, std::span<std::byte> bytes) {
        return TraitsOfT::EncodeInto(*static_cast<const T*>(message), bytes);
      };
    }
    if constexpr (requires(const T& message) { TraitsOfT::EncodeInPlace(message); }) {
      info.encode_in_place = [](const void* message) -> Payload {
        return TraitsOfT::EncodeInPlace(*static_cast<const T*>(message));
      };
    }
    if constexpr (requires(const T& message) { TraitsOfT::LargePart(message); }) {
      info.large_part = [](const void* message) { return TraitsOfT::LargePart(*static_cast<const T*>(message)); };
    }
    info.decode = [](const Payload& payload) -> AnyMessage {
      try {
        return TraitsOfT::Decode(payload);
      } catch (...) {
        return nullptr;
      }
    };
  }
  if constexpr (kIsBulk<T>) {
    info.other_cpp_type = typeid(typename T::Plain);
    info.to_other = [](const AnyMessage& message) -> AnyMessage {
      try {
        return TraitsOfT::ToOther(message);
      } catch (...) {
        return nullptr;
      }
    };
    info.from_other = [](const AnyMessage& message) -> AnyMessage {
      try {
        return TraitsOfT::FromOther(message);
      } catch (...) {
        return nullptr;
      }
    };
  }
  if constexpr (requires { SchemaOf<T>::Get(); }) {
    info.descriptor = [] { return SchemaOf<T>::Get(); };
    info.descriptor_set = [] { return DescriptorSet(*SchemaOf<T>::Get()); };
  }
  return info;
}

}  // namespace hgros::codec
