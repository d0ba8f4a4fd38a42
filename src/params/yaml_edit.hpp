#pragma once

#include <string>
#include <vector>

#include "hgros/params/param_node.hpp"
#include "hgros/params/param_path.hpp"

namespace hgros {

// Puts values into the text of a YAML file.
//
// Each edit replaces the characters of one value, or adds a line to the map where it belongs, so that comments, order
// and spelling of everything else stay. The result is read again; where it does not say what was wanted (values that
// others repeat by an alias, unusual layouts), the file is written anew from its values, and its comments are lost.
struct YamlEdit {
  ParamPath path;  // keys alone
  ParamNodePtr value;
};
struct EditedYaml {
  std::string text;
  bool comments_kept = true;
};
// Throws ConfigError if the result cannot be read, because a value is not UTF-8, or if `text` is no file of parameters;
// `name` stands for the file.
[[nodiscard]] EditedYaml EditYaml(const std::string& text, const std::string& name, const std::vector<YamlEdit>& edits);

// All of `root` as a file; throws ConfigError or ParamError if that cannot be read again.
[[nodiscard]] std::string WrittenYaml(const ParamNodePtr& root, const std::string& name);

}  // namespace hgros
