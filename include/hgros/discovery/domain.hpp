#pragma once

#include <cstddef>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// Sessions of different domains do not find each other: two robots on one host, a test beside the real thing.
inline constexpr std::string_view kDefaultDomain = "default";

/// A session configured for this domain does not look for other sessions.
inline constexpr std::string_view kNoDomain = "none";

inline constexpr std::size_t kMaxDomainLength = 64;

/// Whether `name` can name a domain: 1 to 64 letters, digits, '_', '-' and '.', and no '.' at the start.
[[nodiscard]] HGROS_EXPORT bool IsDomain(std::string_view name) noexcept;

/// Throws Error if `name` cannot name a domain.
HGROS_EXPORT void RequireDomain(std::string_view name);

}  // namespace hgros
