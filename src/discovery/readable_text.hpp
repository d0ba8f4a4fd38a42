#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hgros::discovery {

inline constexpr std::size_t kMaxTextBytes = 256;  // Limit of displayed names, type names and endpoints.

/// `text` without control characters, cut to kMaxTextBytes.
[[nodiscard]] std::string Readable(std::string_view text);

}  // namespace hgros::discovery
