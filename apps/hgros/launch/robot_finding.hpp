#pragma once

#include <string>

#include "hgros/base/error.hpp"

namespace hgros::cli {

/// Something that a robot lacks, or that its components do not agree on.
struct RobotFinding {
  bool fault = false;  ///< Otherwise a warning: a program, or another robot, may have what is missing.
  FilePosition at;     ///< Of the wrong value, or of the component.
  std::string what;
  std::string fix;
  std::string channel = {};  ///< Or the service that it is about, if any.

  [[nodiscard]] std::string Text() const { return at.ToString() + ": " + what + (fix.empty() ? "" : " " + fix); }
};

}  // namespace hgros::cli
