#pragma once

#include <string>
#include <vector>

#include "hgros/params/param_node.hpp"
#include "hgros/params/param_path.hpp"

namespace hgros {

// Puts values into the text of a YAML file.
//
// Each edit replaces the characters of one value, or adds a line to the map where it belongs, so that the comments, the
// order and the spelling of everything else stay. The result is read again. If it does not have the wanted values (when
// an alias repeats the value, or the layout is unusual), the file is written from its values, and its comments are
// lost.
struct YamlEdit {
  ParamPath path;  // keys alone
  ParamNodePtr value;
};
struct EditedYaml {
  std::string text;
  bool comments_kept = true;
};
// Throws ConfigError if a value is not UTF-8, so that the result cannot be read, or if `text` is not a parameter file.
// Errors name the file by `name`.
[[nodiscard]] EditedYaml EditYaml(const std::string& text, const std::string& name, const std::vector<YamlEdit>& edits);

// The text of a file with all values of `root`. Throws ConfigError or ParamError if it could not be read again.
[[nodiscard]] std::string WrittenYaml(const ParamNodePtr& root, const std::string& name);

}  // namespace hgros
