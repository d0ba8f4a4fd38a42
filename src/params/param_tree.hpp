#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/params/param_node.hpp"
#include "hgros/params/param_path.hpp"
#include "hgros/params/param_view.hpp"
#include "hgros/yaml/document.hpp"

// Operations on parameter trees. Trees are immutable: each operation returns a new tree.
namespace hgros::param_tree {

// An empty map.
[[nodiscard]] ParamNodePtr EmptyRoot();

// The tree of a YAML file. Throws ConfigError if its top is neither a map nor empty.
[[nodiscard]] ParamNodePtr FromDocument(const yaml::Document& document);
// The tree of a part of a YAML file, without positions.
[[nodiscard]] ParamNodePtr FromNode(const yaml::Node& node);
// The tree of a single value, such as one from the command line. `origin` is the origin of every node.
[[nodiscard]] ParamNodePtr FromValue(std::string_view yaml, const ParamOrigin& origin);
// Of a command line or the environment.
[[nodiscard]] ParamNodePtr FromArgument(const std::string& argument, const std::string& said);
// The same value with `origin` as the origin of every node.
[[nodiscard]] ParamNodePtr WithOrigin(const ParamNode& node, const ParamOrigin& origin);

// Merges maps. Everything else is replaced by `upper`, but an empty value leaves a map unchanged.
[[nodiscard]] ParamNodePtr Merged(const ParamNodePtr& lower, const ParamNodePtr& upper);

// Sets `path` to `value`, or removes it if `value` is null. Creates missing maps on the path; an empty value counts as
// missing. Throws ParamError if the path leads through something else, or beyond the end of a list.
[[nodiscard]] ParamNodePtr With(const ParamNodePtr& root, const ParamPath& path, const ParamNodePtr& value);

[[nodiscard]] ParamNodePtr Find(const ParamNodePtr& root, const ParamPath& path);

// The paths of all values at and below `view` that are not maps, in the order of the files.
[[nodiscard]] std::vector<std::string> ListBelow(const ParamView& view);

// `root` without the sections that configure the session, which often are in the same file.
[[nodiscard]] ParamNodePtr WithoutSession(const ParamNodePtr& root);
// Throws ParamError if `path` is in such a section.
void RequireNotSession(const ParamPath& path);

// One difference between two trees: a value that is not a map in both, or that exists in only one of them.
struct Difference {
  ParamPath path;
  ParamNodePtr before;  // null if it does not exist; `after`, too
  ParamNodePtr after;
};
// In the order of `after`, followed by values that only `before` has.
[[nodiscard]] std::vector<Difference> Differences(const ParamNodePtr& before, const ParamNodePtr& after);

}  // namespace hgros::param_tree
