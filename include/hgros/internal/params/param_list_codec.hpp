#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hgros/params/param_view.hpp"

namespace hgros {

namespace params_detail {

template <class T, class Elements>
ParamNode WriteList(const Elements& elements) {
  std::vector<ParamNode> items;
  for (const auto& element : elements) items.push_back(ParamCodec<T>::Write(element));
  return ParamNode::List(std::move(items));
}

}  // namespace params_detail

/// Empty for a missing parameter and for an empty value.
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

}  // namespace hgros
