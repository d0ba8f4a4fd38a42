#pragma once

#include <string>
#include <vector>

#include "doctor/finding.hpp"
#include "hgros/base/error.hpp"

namespace hgros::cli {

/// One thing that `hgros check` has found in files.
struct FileFinding {
  Severity severity = Severity::kFault;
  std::string check;  ///< The name of the check, for JSON: "file", "channel", ...
  FilePosition at;    ///< Where it is to be mended.
  std::string what;   ///< A sentence.
  std::string fix;
  std::string channel = {};  ///< The channel that it is about, if any.
  FilePosition other = {};   ///< The place that contradicts.
};

/// "robot.yaml:7"
[[nodiscard]] inline std::string LineOf(const FilePosition& at) { return at.file + ":" + std::to_string(at.line); }

using FileFindings = std::vector<FileFinding>;

}  // namespace hgros::cli
