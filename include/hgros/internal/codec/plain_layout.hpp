#pragma once

#include <array>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "hgros/internal/codec/aggregate_fields.hpp"

namespace hgros {

/// Declares that the bytes of T are its value although the library cannot inspect T: a trivially copyable class with
/// constructors, private members or an anonymous union. Specialize it as true next to the type. Only size and alignment
/// of its layout are then compared.
template <class T>
inline constexpr bool kPlainValue = false;
template <class Rep, class Period>
inline constexpr bool kPlainValue<std::chrono::duration<Rep, Period>> = std::is_arithmetic_v<Rep>;
template <class Clock, class Duration>
inline constexpr bool kPlainValue<std::chrono::time_point<Clock, Duration>> = kPlainValue<Duration>;

namespace codec {

template <class T>
inline constexpr bool kIsStdArray = false;
template <class T, std::size_t N>
inline constexpr bool kIsStdArray<std::array<T, N>> = true;

template <class T>
concept TupleLike = requires {
  std::tuple_size<T>::value;
};

template <class T>
consteval bool IsPlain();

template <class... T>
consteval bool ArePlain(TypeList<T...>) {
  return (IsPlain<std::remove_cv_t<T>>() && ...);
}

/// Structured bindings can decompose this class.
template <class T>
consteval bool IsReflected() {
  if constexpr (!std::is_class_v<T> || !std::is_aggregate_v<T> || TupleLike<T> || kPlainValue<T>) {
    return false;
  } else if constexpr (AggregateWithBase<T>) {
    return false;
  } else {
    return CountFields<T>() <= kMaxAggregateFields;
  }
}

/// The bytes of T are its value, as far as the language lets us see: no pointers, no references and no class with
/// private members, unless kPlainValue allows it. T has no const or volatile.
template <class T>
consteval bool IsPlain() {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    return true;
  } else if constexpr (std::is_array_v<T>) {
    return std::is_bounded_array_v<T> && IsPlain<std::remove_cv_t<std::remove_extent_t<T>>>();
  } else if constexpr (!(std::is_class_v<T> || std::is_union_v<T>) || !std::is_trivially_copyable_v<T> ||
                       !std::default_initializable<T>) {
    return false;
  } else if constexpr (kPlainValue<T> || std::is_union_v<T>) {
    return true;
  } else if constexpr (kIsStdArray<T>) {
    return IsPlain<std::remove_cv_t<typename T::value_type>>();
  } else if constexpr (IsReflected<T>()) {
    return ArePlain(decltype(FieldTypes(std::declval<T&>())){});
  } else {
    return std::is_aggregate_v<T>;
  }
}

template <class T>
std::string LayoutText();

template <class Element>
std::string ArrayText(std::size_t count) {
  return std::string("[").append(std::to_string(count)).append("*").append(LayoutText<Element>()).append("]");
}

template <class... T>
std::string FieldsText(TypeList<T...>) {
  std::string text;
  (text.append(LayoutText<std::remove_cv_t<T>>()).append(","), ...);
  if (!text.empty()) text.pop_back();
  return text;
}

/// Sizes and kinds in order, as text; the grammar is in docs/wire-protocol.md ("Fingerprint of a plain struct").
/// The ABI's rules determine the offsets from these.
template <class T>
std::string LayoutText() {
  const auto sized = [](const char* kind) { return std::string(kind).append(std::to_string(sizeof(T))); };
  const auto sized_and_aligned = [&](const char* kind) {
    return sized(kind).append("/").append(std::to_string(alignof(T)));
  };
  if constexpr (std::is_same_v<T, bool>) {
    return sized("b");
  } else if constexpr (std::is_same_v<T, char> || std::is_same_v<T, wchar_t>) {
    return sized("c");  // Signed on x86, unsigned on ARM; text is the same on both.
  } else if constexpr (std::is_floating_point_v<T>) {
    return sized("f");
  } else if constexpr (std::is_integral_v<T>) {
    return sized(std::is_signed_v<T> ? "s" : "u");
  } else if constexpr (std::is_enum_v<T>) {
    return std::string("e").append(LayoutText<std::underlying_type_t<T>>());
  } else if constexpr (std::is_array_v<T>) {
    return ArrayText<std::remove_cv_t<std::remove_extent_t<T>>>(std::extent_v<T>);
  } else if constexpr (kIsStdArray<T> && !kPlainValue<T>) {
    return ArrayText<std::remove_cv_t<typename T::value_type>>(std::tuple_size_v<T>);
  } else if constexpr (IsReflected<T>()) {
    return sized_and_aligned("{")
        .append(":")
        .append(FieldsText(decltype(FieldTypes(std::declval<T&>())){}))
        .append("}");
  } else {
    return sized_and_aligned("o");
  }
}

}  // namespace codec
}  // namespace hgros
