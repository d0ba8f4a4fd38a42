#pragma once

#include <string>

#include "hgros/base/export.hpp"

namespace hgros {

/// The source line of a call: as the default argument `CallSite::Current()`, the line of the caller. Replaces
/// std::source_location, which clang lacks before version 16.
struct HGROS_EXPORT CallSite {
  const char* file = "";
  int line = 0;

  [[nodiscard]] static constexpr CallSite Current(const char* file = __builtin_FILE(),
                                                  int line = __builtin_LINE()) noexcept {
    return {file, line};
  }
  /// "file:line", or "file" alone if the line is 0.
  [[nodiscard]] std::string ToString() const {
    return line == 0 ? std::string(file) : std::string(file) + ":" + std::to_string(line);
  }
};

}  // namespace hgros
