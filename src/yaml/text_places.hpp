#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros::yaml {

/// Finds lines and columns (both from 1, columns in characters) in UTF-8 text. Requests in about the order of the text
/// are cheap, even in long lines.
class TextPlaces {
 public:
  explicit TextPlaces(std::string_view text);

  /// `line` and `byte_column` count from 0, as yaml-cpp does. A position beyond the text gives its end.
  [[nodiscard]] FilePosition At(const std::string& file, int line, int byte_column);
  /// The line without its break; empty beyond the text. Counts from 0.
  [[nodiscard]] std::string_view Line(int line) const noexcept;
  [[nodiscard]] std::size_t Offset(int line, int byte_column) const noexcept;
  [[nodiscard]] std::string_view text() const noexcept { return text_; }

 private:
  std::string_view text_;
  std::vector<std::size_t> line_starts_;
  int line_ = 0;  // the position of the last request
  std::size_t offset_ = 0;
  int characters_ = 0;  // of line_ before offset_
};

/// Throws ConfigError at the first byte that is not UTF-8 or is a control character other than tab and line break.
void RequireCleanText(TextPlaces& places, const std::string& name);

}  // namespace hgros::yaml
