#pragma once

#include <array>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/params/param_view.hpp"

namespace hgros {

/// Specialize it for an enumeration: `static constexpr std::array kNames{std::pair{"fast", Mode::kFast}, ...};`
template <class E>
struct ParamEnum;

/// Specialize it for a struct: `static constexpr std::tuple kFields{ParamField{"gain", &Pid::gain}, ...};`
/// A map is read into it: what it does not name keeps its default, and a key that is no field is an error.
template <class T>
struct ParamFields;

template <class T, class Member>
struct ParamField {
  const char* name;
  Member T::*member;
};

namespace params_detail {

[[nodiscard]] HGROS_EXPORT bool ReadBoolean(const ParamView& view);
[[nodiscard]] HGROS_EXPORT double ReadNumber(const ParamView& view);
[[nodiscard]] HGROS_EXPORT std::int64_t ReadInteger(const ParamView& view, std::int64_t least, std::int64_t most);
[[nodiscard]] HGROS_EXPORT std::uint64_t ReadUnsigned(const ParamView& view, std::uint64_t most);
[[nodiscard]] HGROS_EXPORT std::string ReadText(const ParamView& view);
/// A number with ns, us, ms, s, min or h, as in 250ms, or a number of seconds.
[[nodiscard]] HGROS_EXPORT std::chrono::nanoseconds ReadDuration(const ParamView& view);
[[nodiscard]] HGROS_EXPORT std::size_t ReadChoice(const ParamView& view, const std::vector<std::string>& names);
[[nodiscard]] HGROS_EXPORT ParamNode WriteNumber(double number);
[[nodiscard]] HGROS_EXPORT ParamNode WriteDuration(std::chrono::nanoseconds duration);

/// A dense matrix or vector as Eigen has them, without a need for its headers here.
template <class T>
concept DenseMatrix = requires(const T m) {
  typename T::Scalar;
  { int(T::RowsAtCompileTime) } -> std::same_as<int>;
  { int(T::ColsAtCompileTime) } -> std::same_as<int>;
  m(0, 0);
  m.rows();
  m.cols();
};

template <class E>
concept NamedEnum = std::is_enum_v<E> && requires {
  ParamEnum<E>::kNames;
};

template <class T>
concept NamedFields = requires {
  ParamFields<T>::kFields;
};

template <class T, class Elements>
ParamNode WriteList(const Elements& elements) {
  std::vector<ParamNode> items;
  for (const auto& element : elements) items.push_back(ParamCodec<T>::Write(element));
  return ParamNode::List(std::move(items));
}

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

/// Empty for nothing and for an empty value.
template <class T>
struct ParamCodec<std::optional<T>> {
  [[nodiscard]] static std::optional<T> Read(const ParamView& view) {
    if (!view.exists() || view.is_null()) return std::nullopt;
    return ParamCodec<T>::Read(view);
  }
  [[nodiscard]] static ParamNode Write(const std::optional<T>& value) {
    return value ? ParamCodec<T>::Write(*value) : ParamNode();
  }
};

template <class T>
struct ParamCodec<std::vector<T>> {
  [[nodiscard]] static std::vector<T> Read(const ParamView& view) {
    view.RequireList("a list");
    std::vector<T> values;
    values.reserve(view.size());
    for (std::size_t i = 0; i < view.size(); ++i) values.push_back(ParamCodec<T>::Read(view[i]));
    return values;
  }
  [[nodiscard]] static ParamNode Write(const std::vector<T>& values) { return params_detail::WriteList<T>(values); }
};

template <class T, std::size_t N>
struct ParamCodec<std::array<T, N>> {
  [[nodiscard]] static std::array<T, N> Read(const ParamView& view) {
    const std::string wanted = "a list of " + std::to_string(N);
    view.RequireList(wanted);
    if (view.size() != N) view.FailType(wanted);
    std::array<T, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = ParamCodec<T>::Read(view[i]);
    return values;
  }
  [[nodiscard]] static ParamNode Write(const std::array<T, N>& values) { return params_detail::WriteList<T>(values); }
};

template <class T, class Less>
struct ParamCodec<std::map<std::string, T, Less>> {
  using Value = std::map<std::string, T, Less>;
  [[nodiscard]] static Value Read(const ParamView& view) {
    view.RequireMap("a map");
    Value values;
    for (const std::string& key : view.keys()) values.emplace(key, ParamCodec<T>::Read(view[key]));
    return values;
  }
  [[nodiscard]] static ParamNode Write(const Value& values) {
    std::vector<std::pair<std::string, ParamNode>> entries;
    for (const auto& [key, value] : values) entries.emplace_back(key, ParamCodec<T>::Write(value));
    return ParamNode::Map(std::move(entries));
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

template <params_detail::NamedFields T>
struct ParamCodec<T> {
  [[nodiscard]] static T Read(const ParamView& view) {
    view.RequireMap("a map");
    T value{};
    std::apply(
        [&](const auto&... field) {
          view.RequireKeys({field.name...});
          (ReadField(view[field.name], value.*(field.member)), ...);
        },
        ParamFields<T>::kFields);
    return value;
  }
  [[nodiscard]] static ParamNode Write(const T& value) {
    return std::apply(
        [&](const auto&... field) {
          return ParamNode::Map({{field.name, WriteField(value.*(field.member))}...});
        },
        ParamFields<T>::kFields);
  }

 private:
  template <class M>
  static void ReadField(const ParamView& view, M& member) {
    if (view.exists()) member = ParamCodec<M>::Read(view);
  }
  template <class M>
  static ParamNode WriteField(const M& member) {
    return ParamCodec<M>::Write(member);
  }
};

/// Vectors are lists, matrices are lists of rows.
template <params_detail::DenseMatrix T>
struct ParamCodec<T> {
  using Scalar = typename T::Scalar;
  static constexpr int kRows = T::RowsAtCompileTime;
  static constexpr int kCols = T::ColsAtCompileTime;
  static constexpr bool kVector = kRows == 1 || kCols == 1;

  [[nodiscard]] static T Read(const ParamView& view) {
    const std::string wanted = Wanted();
    view.RequireList(wanted);
    const std::size_t height = view.size();
    T matrix;
    if constexpr (kVector) {
      if (!Fits(height, kRows == 1 ? kCols : kRows)) view.FailType(wanted);
      if constexpr (kRows < 0 || kCols < 0) matrix.resize(static_cast<int>(height));
      for (std::size_t i = 0; i < height; ++i) matrix(static_cast<int>(i)) = ParamCodec<Scalar>::Read(view[i]);
    } else {
      const std::size_t width = height == 0 ? 0 : view[0].size();
      if (!Fits(height, kRows) || !Fits(width, kCols)) view.FailType(wanted);
      if constexpr (kRows < 0 || kCols < 0) matrix.resize(static_cast<int>(height), static_cast<int>(width));
      for (std::size_t row = 0; row < height; ++row) {
        const ParamView line = view[row];
        line.RequireList("a list of " + std::to_string(width) + " numbers");
        if (line.size() != width) line.FailType("a list of " + std::to_string(width) + " numbers");
        for (std::size_t col = 0; col < width; ++col) {
          matrix(static_cast<int>(row), static_cast<int>(col)) = ParamCodec<Scalar>::Read(line[col]);
        }
      }
    }
    return matrix;
  }

  [[nodiscard]] static ParamNode Write(const T& matrix) {
    std::vector<ParamNode> rows;
    for (int row = 0; row < matrix.rows(); ++row) {
      std::vector<ParamNode> line;
      for (int col = 0; col < matrix.cols(); ++col) line.push_back(ParamCodec<Scalar>::Write(matrix(row, col)));
      if constexpr (kVector) {
        for (ParamNode& number : line) rows.push_back(std::move(number));
      } else {
        rows.push_back(ParamNode::List(std::move(line)));
      }
    }
    return ParamNode::List(std::move(rows));
  }

 private:
  static constexpr bool Fits(std::size_t size, int fixed) {
    return fixed < 0 || size == static_cast<std::size_t>(fixed);
  }
  static std::string Wanted() {
    const auto count = [](int fixed) { return fixed < 0 ? std::string() : std::to_string(fixed) + " "; };
    if constexpr (kVector) return "a list of " + count(kRows == 1 ? kCols : kRows) + "numbers";
    return "a list of " + count(kRows) + "rows of " + count(kCols) + "numbers";
  }
};

}  // namespace hgros
