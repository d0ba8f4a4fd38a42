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

/// The number of columns that visible text takes: its characters. Wide characters count as one.
[[nodiscard]] std::size_t ColumnsOf(std::string_view visible) noexcept;

}  // namespace hgros::cli
