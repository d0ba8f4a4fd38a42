#pragma once

#include <string>

#include "hgros/base/export.hpp"

namespace hgros {

/// Where in the program a call stands; as the default argument `CallSite::Current()`, where that function is called.
/// In place of std::source_location, which clang has only since version 16.
struct HGROS_EXPORT CallSite {
  const char* file = "";
  int line = 0;

  [[nodiscard]] static constexpr CallSite Current(const char* file = __builtin_FILE(),
                                                  int line = __builtin_LINE()) noexcept {
    return {file, line};
  }
  /// "file:line".
  [[nodiscard]] std::string ToString() const { return std::string(file) + ":" + std::to_string(line); }
};

}  // namespace hgros
