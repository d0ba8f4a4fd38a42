#pragma once

#include <cstddef>
#include <string_view>

namespace hgros::viewer {

/// As much of somebody else's text as is shown at once. ImGui ends the program if one text has more than 16,383 letters
/// that are in view.
inline constexpr std::size_t kMaxShownBytes = 4096;

/// The beginning of `text`: at most `most` bytes, and no part of a UTF-8 character.
[[nodiscard]] std::string_view CutText(std::string_view text, std::size_t most = kMaxShownBytes) noexcept;

}  // namespace hgros::viewer
