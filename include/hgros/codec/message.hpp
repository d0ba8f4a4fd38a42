#pragma once

#include <type_traits>

#include "hgros/codec/block.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/make_type_info.hpp"

namespace hgros {
/// T can be sent to other processes. How is decided at compile time, by the first that fits:
///  1. a CustomCodec<T>;
///  2. T is a generated protobuf class, or a Bulk of one;
///  3. T has SerializeToString and ParseFromString (SerializesItself);
///  4. T is plain data (PlainStruct).
/// Any other type can still be passed by pointer inside a process.
template <class T>
concept Message = std::is_object_v<T> && std::is_same_v<T, std::remove_cv_t<T>> && !std::is_array_v<T> &&
                  codec::Traits<T>::kEncoding != Encoding::kNone;

template <class T>
inline constexpr bool kIsMessage = Message<T>;  ///< A plain boolean: compilers report its failure in one line.

/// Refuses a T that is not a Message with one sentence.
template <class T>
constexpr void RequireMessage() noexcept {
  static_assert(
      kIsMessage<T>,
      "This type cannot be a message. A message is a class that protoc generated, a plain struct of numbers, enums and "
      "arrays of these (no std::string, no std::vector, no pointer), a class with SerializeToString and "
      "ParseFromString, or a type for which hgros::CustomCodec is specialized before its first use. What stays inside "
      "the process (ToGraph, FromGraph) may be any type. Read on in hgros/codec/message.hpp, or in docs/how-to.md "
      "under \"Send your own types\".");
}

/// The library's description of T, a complete object type without const or volatile. If T is not a Message its encoding
/// is kNone and its name is the C++ name. Created at the first call.
template <class T>
[[nodiscard]] const TypeInfo& TypeOf() {
  static_assert(std::is_object_v<T> && !std::is_array_v<T> && std::is_same_v<T, std::remove_cv_t<T>>,
                "a message type is an object type without const or volatile");
  static const TypeInfo info = codec::MakeTypeInfo<T>();
  return info;
}

}  // namespace hgros
