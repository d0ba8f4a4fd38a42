#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <typeinfo>

#include "hgros/base/cause.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/message.hpp"

namespace hgros {

/// A request or a reply with the id of its call, as the channels of services carry it: inside a session by pointer,
/// elsewhere as docs/wire-protocol.md describes under "Services". It never changes after it was sent.
struct CallMessage {
  enum class Outcome : std::uint8_t {
    kOk = 0,
    kHandlerFailed = 1,
    kFull = 2,
    kEnded = 3,
    kNotWritable = 4,
    kTypeMismatch = 5,
  };
  std::uint64_t caller = 0;
  std::uint64_t server = 0;
  std::uint64_t call = 0;
  std::int64_t patience_ns = 0;  ///< 0: forever.
  std::string reply_type;
  bool cancelled = false;
  Outcome outcome = Outcome::kOk;
  std::string text;
  AnyMessage body;
  const TypeInfo* type = nullptr;  ///< Type of the body.
  Cause cause;                     ///< Goes with the packet; not in the data.
};

namespace codec {

/// On the wire: the head, followed by the body. A message that cannot be written becomes Outcome::kNotWritable.
HGROS_EXPORT Payload EncodeCall(const AnyMessage& call);
HGROS_EXPORT std::size_t EncodedCallBytes(const void* call);
HGROS_EXPORT bool EncodeCallInto(const void* call, std::span<std::byte> bytes);
/// Null if the bytes are not such a message or the body is not of `type`.
HGROS_EXPORT AnyMessage DecodeCall(const Payload& payload, const TypeInfo& type);

}  // namespace codec

/// The type of a channel that carries calls with bodies of type T. Its name, encoding, fingerprint and schema are those
/// of T, so that channels detect mismatches and schemas can evolve as for T. Created at the first call.
template <class T>
[[nodiscard]] const TypeInfo& CallTypeOf() {
  struct Call : CallMessage {};  // A C++ type of its own for each T.
  static const TypeInfo info = [] {
    TypeInfo call = TypeOf<T>();
    call.cpp_type = typeid(Call);
    call.memory_bytes = [](const void* message) {
      const auto& one = *static_cast<const CallMessage*>(message);
      return sizeof(CallMessage) + (one.body ? one.type->memory_bytes(one.body.get()) : 0);
    };
    call.encode = &codec::EncodeCall;
    call.encoded_bytes = TypeOf<T>().encode_into == nullptr ? nullptr : &codec::EncodedCallBytes;
    call.encode_into = TypeOf<T>().encode_into == nullptr ? nullptr : &codec::EncodeCallInto;
    call.encode_in_place = nullptr;
    call.large_part = nullptr;
    call.encode_copy = nullptr;
    call.decode = [](const Payload& payload) { return codec::DecodeCall(payload, TypeOf<T>()); };
    call.other_cpp_type = typeid(void);
    call.to_other = nullptr;
    call.from_other = nullptr;
    return call;
  }();
  return info;
}

}  // namespace hgros
