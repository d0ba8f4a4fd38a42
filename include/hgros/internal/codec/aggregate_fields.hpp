#pragma once

#include <cstddef>

#include "hgros/internal/codec/count_fields.hpp"

namespace hgros::codec {

template <class... T>
struct TypeList {
  static constexpr std::size_t kSize = sizeof...(T);
};

/// The declared types of the fields of an aggregate, in order, as the T of the returned TypeList. Never called.
template <class T>
auto FieldTypes(T& value) {
  constexpr std::size_t kCount = CountFields<T>();
  static_assert(kCount <= kMaxAggregateFields);
  if constexpr (kCount == 0) {
    return TypeList<>{};
  } else if constexpr (kCount == 1) {
    auto& [f1] = value;
    return TypeList<decltype(f1)>{};
  } else if constexpr (kCount == 2) {
    auto& [f1, f2] = value;
    return TypeList<decltype(f1), decltype(f2)>{};
  } else if constexpr (kCount == 3) {
    auto& [f1, f2, f3] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3)>{};
  } else if constexpr (kCount == 4) {
    auto& [f1, f2, f3, f4] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4)>{};
  } else if constexpr (kCount == 5) {
    auto& [f1, f2, f3, f4, f5] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5)>{};
  } else if constexpr (kCount == 6) {
    auto& [f1, f2, f3, f4, f5, f6] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6)>{};
  } else if constexpr (kCount == 7) {
    auto& [f1, f2, f3, f4, f5, f6, f7] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7)>{};
  } else if constexpr (kCount == 8) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8)>{};
  } else if constexpr (kCount == 9) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9)>{};
  } else if constexpr (kCount == 10) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10)>{};
  } else if constexpr (kCount == 11) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11)>{};
  } else if constexpr (kCount == 12) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12)>{};
  } else if constexpr (kCount == 13) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13)>{};
  } else if constexpr (kCount == 14) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14)>{};
  } else if constexpr (kCount == 15) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15)>{};
  } else if constexpr (kCount == 16) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16)>{};
  } else if constexpr (kCount == 17) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17)>{};
  } else if constexpr (kCount == 18) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18)>{};
  } else if constexpr (kCount == 19) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19)>{};
  } else if constexpr (kCount == 20) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19),
                    decltype(f20)>{};
  } else if constexpr (kCount == 21) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19),
                    decltype(f20), decltype(f21)>{};
  } else if constexpr (kCount == 22) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19),
                    decltype(f20), decltype(f21), decltype(f22)>{};
  } else if constexpr (kCount == 23) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23] =
        value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19),
                    decltype(f20), decltype(f21), decltype(f22), decltype(f23)>{};
  } else if constexpr (kCount == 24) {
    auto& [f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19, f20, f21, f22, f23,
           f24] = value;
    return TypeList<decltype(f1), decltype(f2), decltype(f3), decltype(f4), decltype(f5), decltype(f6), decltype(f7),
                    decltype(f8), decltype(f9), decltype(f10), decltype(f11), decltype(f12), decltype(f13),
                    decltype(f14), decltype(f15), decltype(f16), decltype(f17), decltype(f18), decltype(f19),
                    decltype(f20), decltype(f21), decltype(f22), decltype(f23), decltype(f24)>{};
  }
}

}  // namespace hgros::codec
