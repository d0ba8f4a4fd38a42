#pragma once

#include <string>

#include "hgros/base/error.hpp"

namespace hgros::cli {

/// Something that a robot lacks, or that its components do not agree on.
struct RobotFinding {
  bool fault = false;  ///< Otherwise a warning: a program, or another robot, may have what is missing.
  FilePosition at;     ///< Of the component.
  std::string what;
  std::string fix;

  /// All of it. A fault of a value has a place of its own.
  [[nodiscard]] std::string Text() const {
    const bool has_place = what.find(at.file + ":") != std::string::npos;
    return (has_place ? what : at.ToString() + ": " + what) + (fix.empty() ? "" : " " + fix);
  }
};

}  // namespace hgros::cli
