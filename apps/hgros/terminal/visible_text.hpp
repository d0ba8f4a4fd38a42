#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hgros::cli {

/// `text` from a robot as it may be shown in a terminal: control characters, characters that change the direction of
/// text and bytes that are not UTF-8 are written as \n, \t, \xNN or \uNNNN. Line breaks, too.
[[nodiscard]] std::string Visible(std::string_view text);

/// The same for several lines; their ends stay.
[[nodiscard]] std::string VisibleLines(std::string_view text);

/// `text` with bytes that are not UTF-8 replaced by U+FFFD.
[[nodiscard]] std::string ValidUtf8(std::string_view text);

/// The number of columns that visible text takes. Without a locale of the user, each character counts as one.
[[nodiscard]] std::size_t ColumnsOf(std::string_view visible) noexcept;
/// The beginning of visible text that takes at most so many columns.
[[nodiscard]] std::string_view FirstColumns(std::string_view visible, std::size_t columns) noexcept;
/// The same, with "..." at its end if something is left out.
[[nodiscard]] std::string Shortened(std::string_view visible, std::size_t columns);

}  // namespace hgros::cli
