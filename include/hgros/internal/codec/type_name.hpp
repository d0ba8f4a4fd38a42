#pragma once

#include <string>
#include <typeinfo>

#include "hgros/base/export.hpp"

namespace hgros {

/// The C++ name of a type as a programmer writes it, such as "lidar::Scan". Equal for compilers that share the
/// Itanium C++ ABI (GCC, Clang).
[[nodiscard]] HGROS_EXPORT std::string CppTypeName(const std::type_info& type);

}  // namespace hgros
