#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hgros::yaml {

/// A syntax error as explained to the author of the file.
struct SyntaxFault {
  std::string what;
  std::string mend;
  std::optional<int> byte_column;  ///< In the line, from 0, where it is not the place that yaml-cpp names.
};

/// Puts yaml-cpp's `message` into sentences. `line` is the text of the line it speaks of.
[[nodiscard]] SyntaxFault ExplainSyntaxError(std::string_view message, std::string_view line);

}  // namespace hgros::yaml
