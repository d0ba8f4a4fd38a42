#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

/// A parameter that is said outside of the files.
struct ParamOverride {
  std::string path;   ///< As in "slam.matcher.max_distance".
  std::string value;  ///< YAML: 3, text, [1, 2] or {x: 1}.
  std::string said;   ///< Where, for errors: "--param slam.matcher.max_distance".
};

/// Where the parameters of a program come from: the files in their order, then the overrides in theirs. What comes
/// later wins; maps are joined.
struct ParamSources {
  std::vector<std::filesystem::path> files = {};
  std::vector<ParamOverride> overrides = {};
};

/// The variables HGROS_PARAM_a__b=value: two underscores stand for a dot, the letters are taken as they are.
[[nodiscard]] HGROS_EXPORT std::vector<ParamOverride> ParamOverridesOfEnvironment();

/// Takes every `--param a.b=value` and `--param=a.b=value` out of a program's arguments, up to a `--`. Throws
/// ParamError for one without a path or without a value.
[[nodiscard]] HGROS_EXPORT std::vector<ParamOverride> TakeParamArguments(std::vector<std::string>& arguments);

}  // namespace hgros
