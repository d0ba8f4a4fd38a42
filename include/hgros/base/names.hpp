#pragma once

#include <span>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// The maximum length of a channel name in bytes. ZeroMQ 4.3.4 mishandles topics of 246 to 255 bytes, and ours append a
/// session id.
inline constexpr std::size_t kMaxChannelNameLength = 200;

/// Checks a channel name: 1 to kMaxChannelNameLength bytes of valid UTF-8 (packets carry names in protobuf strings)
/// without spaces, control characters and characters that change the direction of text (U+202A to U+202E, U+2066 to
/// U+2069). Slashes are allowed. Returns an empty text, or what is wrong.
[[nodiscard]] HGROS_EXPORT std::string ChannelNameFault(std::string_view name);

/// Throws Error naming the fault if `name` is not a channel name.
HGROS_EXPORT void RequireChannelName(std::string_view name);

/// The candidate with the smallest edit distance to `name`, the first of equal ones. Empty if more than a third of it
/// differs, because then it is unlikely to be meant.
[[nodiscard]] HGROS_EXPORT std::string NearestName(std::string_view name, std::span<const std::string> candidates);

}  // namespace hgros
