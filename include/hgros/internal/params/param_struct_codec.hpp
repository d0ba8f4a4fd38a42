#pragma once

#include <tuple>

#include "hgros/params/param_view.hpp"

namespace hgros {

/// Specialize this for a struct: `static constexpr std::tuple kFields{ParamField{"gain", &Pid::gain}, ...};`
/// It is read from a map: missing fields keep their defaults, and an unknown key is an error.
template <class T>
struct ParamFields;

template <class T, class Member>
struct ParamField {
  const char* name;
  Member T::*member;
};
template <class T, class Member>
ParamField(const char*, Member T::*) -> ParamField<T, Member>;  // Clang has it by itself from version 17.

namespace params_detail {

template <class T>
concept NamedFields = requires {
  ParamFields<T>::kFields;
};

}  // namespace params_detail

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

}  // namespace hgros
