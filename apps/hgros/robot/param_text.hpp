#pragma once

#include <string>

#include "hgros/params/param_node.hpp"
#include "hgros/params/param_server.hpp"
#include "terminal/json.hpp"

namespace hgros::cli {

/// A value as YAML in one line: 0.5, "text", [1, 2], {x: 1}. Visible.
[[nodiscard]] std::string FlowText(const ParamNode& node);
/// Which values a parameter can have: "0 to 1", "red, green"; empty: any. Visible.
[[nodiscard]] std::string RangeText(const ParamInfo& info);
/// A value as JSON: numbers and booleans as such, everything else as text.
void WriteJson(Json& json, const ParamNode& node);

}  // namespace hgros::cli
