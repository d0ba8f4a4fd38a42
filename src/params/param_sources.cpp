#include "hgros/params/param_sources.hpp"

#include <unistd.h>

#include <algorithm>
#include <string_view>

#include "hgros/params/param_error.hpp"
#include "hgros/yaml/quoted.hpp"
#include "params/param_server_core.hpp"

namespace hgros {

std::vector<ParamOverride> ParamOverridesOfEnvironment() {
  std::vector<ParamOverride> overrides;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const std::size_t equals = text.find('=');
    if (!text.starts_with(kEnvironmentPrefix) || equals == std::string_view::npos) continue;
    std::string path(text.substr(kEnvironmentPrefix.size(), equals - kEnvironmentPrefix.size()));
    for (std::size_t at = path.find("__"); at != std::string::npos; at = path.find("__", at + 1)) {
      path.replace(at, 2, ".");
    }
    overrides.push_back({std::move(path), std::string(text.substr(equals + 1)), std::string(text.substr(0, equals))});
  }
  std::sort(overrides.begin(), overrides.end(), [](const auto& a, const auto& b) { return a.said < b.said; });
  return overrides;
}

std::vector<ParamOverride> TakeParamArguments(std::vector<std::string>& arguments) {
  constexpr std::string_view kOption = "--param";
  std::vector<ParamOverride> overrides;
  std::vector<std::string> others;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--") {
      others.insert(others.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i), arguments.end());
      break;
    }
    std::string assignment;
    if (argument.starts_with("--param=")) {
      assignment = argument.substr(kOption.size() + 1);
    } else if (argument != kOption) {
      others.push_back(argument);
      continue;
    } else if (i + 1 < arguments.size()) {
      assignment = arguments[++i];
    }
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ParamError("--param needs a path and a value, but has " + yaml::Quoted(assignment) + ".", {},
                       "Write it as in --param slam.matcher.max_distance=3.");
    }
    const std::string path = assignment.substr(0, equals);
    overrides.push_back({path, assignment.substr(equals + 1), "--param " + path});
  }
  arguments = std::move(others);
  return overrides;
}

}  // namespace hgros
