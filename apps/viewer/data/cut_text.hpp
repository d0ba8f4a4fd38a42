#pragma once

#include <cstddef>
#include <string_view>

namespace hgros::viewer {

/// The longest text from outside that is shown at once. ImGui ends the program if one text has more than 16,383 visible
/// letters.
inline constexpr std::size_t kMaxShownBytes = 4096;

/// Returns the beginning of `text`: at most `most` bytes, cut between UTF-8 characters.
[[nodiscard]] std::string_view CutText(std::string_view text, std::size_t most = kMaxShownBytes) noexcept;

}  // namespace hgros::viewer
