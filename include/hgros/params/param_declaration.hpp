#pragma once

#include <optional>
#include <string>
#include <vector>

namespace hgros {

/// Describes a parameter when it is declared.
struct ParamInfo {
  std::string description = {};
  std::string unit = {};                  ///< For durations, the range is in seconds.
  std::optional<double> least = {};       ///< For a number, a duration, or each item of a list.
  std::optional<double> most = {};        ///< Both bounds are included.
  std::vector<std::string> choices = {};  ///< For a text, or each item of a list.
  bool read_only = false;                 ///< Keeps the value from the start of the program.
  bool operator==(const ParamInfo&) const = default;
};

struct ParamDeclaration {
  std::string path;
  ParamInfo info;
  std::string type = {};      ///< "bool", "integer", "number", "duration", "text", "list" or "map", as the default is.
  std::string fallback = {};  ///< The default, as YAML. Both are empty if the session's version does not tell them.
};

}  // namespace hgros
