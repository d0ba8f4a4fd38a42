#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/params/param_view.hpp"

namespace hgros {

/// Specialize this for an enumeration: `static constexpr std::array kNames{std::pair{"fast", Mode::kFast}, ...};`
template <class E>
struct ParamEnum;

namespace params_detail {

[[nodiscard]] HGROS_EXPORT bool ReadBoolean(const ParamView& view);
[[nodiscard]] HGROS_EXPORT double ReadNumber(const ParamView& view);
[[nodiscard]] HGROS_EXPORT std::int64_t ReadInteger(const ParamView& view, std::int64_t least, std::int64_t most);
[[nodiscard]] HGROS_EXPORT std::uint64_t ReadUnsigned(const ParamView& view, std::uint64_t most);
[[nodiscard]] HGROS_EXPORT std::string ReadText(const ParamView& view);
/// A number with the unit ns, us, ms, s, min or h, such as 250ms, or a number of seconds.
[[nodiscard]] HGROS_EXPORT std::chrono::nanoseconds ReadDuration(const ParamView& view);
[[nodiscard]] HGROS_EXPORT std::size_t ReadChoice(const ParamView& view, const std::vector<std::string>& names);
[[nodiscard]] HGROS_EXPORT ParamNode WriteNumber(double number);
[[nodiscard]] HGROS_EXPORT ParamNode WriteDuration(std::chrono::nanoseconds duration);

template <class E>
concept NamedEnum = std::is_enum_v<E> && requires {
  ParamEnum<E>::kNames;
};

}  // namespace params_detail

template <>
struct ParamCodec<bool> {
  [[nodiscard]] static bool Read(const ParamView& view) { return params_detail::ReadBoolean(view); }
  [[nodiscard]] static ParamNode Write(bool value) { return ParamNode::Text(value ? "true" : "false", false); }
};

template <std::integral T>
struct ParamCodec<T> {
  [[nodiscard]] static T Read(const ParamView& view) {
    using Limits = std::numeric_limits<T>;
    if constexpr (std::is_signed_v<T>) {
      return static_cast<T>(params_detail::ReadInteger(view, Limits::min(), Limits::max()));
    } else {
      return static_cast<T>(params_detail::ReadUnsigned(view, Limits::max()));
    }
  }
  [[nodiscard]] static ParamNode Write(T value) { return ParamNode::Text(std::to_string(value), false); }
};

template <std::floating_point T>
struct ParamCodec<T> {
  [[nodiscard]] static T Read(const ParamView& view) { return static_cast<T>(params_detail::ReadNumber(view)); }
  [[nodiscard]] static ParamNode Write(T value) { return params_detail::WriteNumber(static_cast<double>(value)); }
};

template <>
struct ParamCodec<std::string> {
  [[nodiscard]] static std::string Read(const ParamView& view) { return params_detail::ReadText(view); }
  [[nodiscard]] static ParamNode Write(std::string value) { return ParamNode::Text(std::move(value), true); }
};

template <class Rep, class Period>
struct ParamCodec<std::chrono::duration<Rep, Period>> {
  using Value = std::chrono::duration<Rep, Period>;
  [[nodiscard]] static Value Read(const ParamView& view) {
    return std::chrono::duration_cast<Value>(params_detail::ReadDuration(view));
  }
  [[nodiscard]] static ParamNode Write(Value value) {
    return params_detail::WriteDuration(std::chrono::duration_cast<std::chrono::nanoseconds>(value));
  }
};

template <params_detail::NamedEnum E>
struct ParamCodec<E> {
  [[nodiscard]] static E Read(const ParamView& view) {
    std::vector<std::string> names;
    for (const auto& [name, value] : ParamEnum<E>::kNames) names.emplace_back(name);
    return ParamEnum<E>::kNames[params_detail::ReadChoice(view, names)].second;
  }
  [[nodiscard]] static ParamNode Write(E value) {
    for (const auto& [name, named] : ParamEnum<E>::kNames) {
      if (named == value) return ParamNode::Text(std::string(name), true);
    }
    throw ParamError("A value of an enumeration has no name.", {}, "Give it one in its ParamEnum.");
  }
};

}  // namespace hgros
