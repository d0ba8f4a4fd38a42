#pragma once

#include <string>
#include <vector>

namespace hgros::cli {

/// Worst first.
enum class Severity {
  kFault,    ///< Something does not work, or messages are lost.
  kWarning,  ///< Something soon may not work.
  kNote,     ///< Worth knowing; nothing is wrong.
};

/// One thing that `hgros doctor` has found.
struct Finding {
  Severity severity = Severity::kNote;
  std::string check;  ///< The name of the check, for JSON: "type", "queue", ...
  std::string what;   ///< One or two sentences, with names as the robot gives them.
  std::string fix;    ///< What to do about it.
};

using Findings = std::vector<Finding>;

[[nodiscard]] const char* NameOf(Severity severity);

}  // namespace hgros::cli
