#pragma once

#include "hgros/params/param_node.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros {

/// The values of a map in a document, with their places. Throws ConfigError if its top is neither a map nor empty.
[[nodiscard]] ParamNodePtr ParamsOf(const yaml::Document& document);

}  // namespace hgros
