#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/params/param_node.hpp"

namespace hgros {

/// A parameter set outside the files.
struct ParamOverride {
  std::string path;   ///< For example "slam.matcher.max_distance".
  std::string value;  ///< YAML: 3, text, [1, 2] or {x: 1}.
  std::string said;   ///< Where it was set, for errors: "--param slam.matcher.max_distance".
};

/// Where the parameters of a program come from: the section, the files in order, then the overrides in order. Later
/// values replace earlier ones; maps are merged.
struct ParamSources {
  std::vector<std::filesystem::path> files = {};
  std::vector<ParamOverride> overrides = {};
  /// A map of values, such as one section of a file. With it, nothing in the sources belongs to a session: parameters
  /// may be named "network" or "time", and who made the section knows of values that nobody declares.
  ParamNodePtr section = nullptr;
};

/// The environment variables HGROS_PARAM_a__b=value: two underscores mean a dot, letters keep their case.
[[nodiscard]] HGROS_EXPORT std::vector<ParamOverride> ParamOverridesOfEnvironment();

/// Removes every `--param a.b=value` and `--param=a.b=value` from a program's arguments, up to `--`, and returns them.
/// Throws ParamError if a path or a value is missing.
[[nodiscard]] HGROS_EXPORT std::vector<ParamOverride> TakeParamArguments(std::vector<std::string>& arguments);

}  // namespace hgros
