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
/// without spaces, control characters and what ends lines or changes the direction of text (U+2028 to U+202E, U+2066 to
/// U+2069). Slashes are allowed. Returns an empty text, or what is wrong.
[[nodiscard]] HGROS_EXPORT std::string ChannelNameFault(std::string_view name);

/// Throws Error naming the fault if `name` is not a channel name.
HGROS_EXPORT void RequireChannelName(std::string_view name);

/// The candidate with the smallest edit distance to `name`, the first of equal ones. Empty if more than a third of it
/// differs, because then it is unlikely to be meant.
[[nodiscard]] HGROS_EXPORT std::string NearestName(std::string_view name, std::span<const std::string> candidates);

/// Whether two names of channels or nodes differ as by a typing error. Stricter than NearestName(), because names such
/// as image_raw and image_rect, arm_l and arm_r or camera1 and camera2 are similar on purpose. Names that differ only
/// in capitals, `_`, `-` or a slash at the beginning are one. Otherwise they must differ in one word: one of at least 4
/// letters, that begins with the same letter, in one letter or two that are swapped; or one of at least 8, that also
/// ends with the same letter, in two.
[[nodiscard]] HGROS_EXPORT bool DifferByATypingError(std::string_view a, std::string_view b);

}  // namespace hgros
