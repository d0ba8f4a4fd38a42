#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hgros::yaml {

/// A syntax error as explained to the author of the file.
struct SyntaxFault {
  std::string what;
  std::string mend;
  std::optional<int> byte_column;  ///< In the line, from 0. Empty if yaml-cpp's column is right.
};

/// Explains yaml-cpp's `message` in sentences. `line` is the text of the line with the error.
[[nodiscard]] SyntaxFault ExplainSyntaxError(std::string_view message, std::string_view line);

}  // namespace hgros::yaml
