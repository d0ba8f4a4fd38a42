#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// The length of the UTF-8 character that `text` begins with; 0 if it begins with none (RFC 3629: neither overlong
/// forms nor surrogates nor anything past U+10FFFF).
[[nodiscard]] HGROS_EXPORT std::size_t Utf8Length(std::string_view text) noexcept;

/// Whether all of it is UTF-8. It may have control characters.
[[nodiscard]] HGROS_EXPORT bool IsUtf8(std::string_view text) noexcept;

/// `text` if it is UTF-8, and else as Readable() shows it. Some languages have no other text.
[[nodiscard]] HGROS_EXPORT std::string AsUtf8(std::string_view text);

/// True if `text` can be shown as it is: UTF-8 without control characters (U+0000 to U+001F, U+007F to U+009F) and
/// without characters that end lines or change the direction of text (U+2028 to U+202E, U+2066 to U+2069). With these,
/// a name or a line of a log can look like another one (CVE-2021-42574).
[[nodiscard]] HGROS_EXPORT bool IsReadable(std::string_view text) noexcept;

/// `text` with everything that IsReadable() refuses escaped: "\n", "\x1b", "\u202e". At most `most_bytes` long; what is
/// beyond is left out.
[[nodiscard]] HGROS_EXPORT std::string Readable(std::string_view text, std::size_t most_bytes = std::string::npos);

}  // namespace hgros
