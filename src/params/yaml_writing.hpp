#pragma once

#include <string>

#include "hgros/params/param_node.hpp"

// Parameters as YAML text.
namespace hgros::yaml_writing {

// On one line: lists and maps with brackets, quotes where they are needed.
[[nodiscard]] std::string Inline(const ParamNode& node);
[[nodiscard]] std::string Key(const std::string& key);
// The entries of a map, each on its own lines, indented by `indent` spaces.
[[nodiscard]] std::string Entries(const ParamNode& map, int indent);
// One entry of a map, in the same form.
[[nodiscard]] std::string Entry(const std::string& key, const ParamNode& value, int indent);

}  // namespace hgros::yaml_writing
