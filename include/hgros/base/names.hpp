#pragma once

#include <span>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// The longest channel name, in bytes. ZeroMQ 4.3.4 mishandles topics of 246 to 255 bytes; ours append a session id.
inline constexpr std::size_t kMaxChannelNameLength = 200;

/// Checks a channel name: 1 to kMaxChannelNameLength bytes, without control characters and blanks (bytes above 0x20,
/// but not 0x7f), in valid UTF-8, because packets carry names in protobuf strings. Slashes are welcome. Returns an
/// empty text if it is good, otherwise what is wrong with it.
[[nodiscard]] HGROS_EXPORT std::string ChannelNameFault(std::string_view name);

/// Throws Error naming the fault if `name` is not a channel name.
HGROS_EXPORT void RequireChannelName(std::string_view name);

/// The candidate nearest to `name` by edit distance, the first among equals; an empty text if none is near enough to be
/// what was meant, that is if more than a third of it differs.
[[nodiscard]] HGROS_EXPORT std::string NearestName(std::string_view name, std::span<const std::string> candidates);

}  // namespace hgros
