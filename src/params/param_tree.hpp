#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/params/param_node.hpp"
#include "hgros/params/param_path.hpp"
#include "hgros/yaml/document.hpp"

// What is done to trees of parameters; each gives a new tree.
namespace hgros::param_tree {

// An empty map.
[[nodiscard]] ParamNodePtr EmptyRoot();

// The tree of a YAML file. Throws ConfigError if its top is neither a map nor empty.
[[nodiscard]] ParamNodePtr FromDocument(const yaml::Document& document);
// A part of one, without its places.
[[nodiscard]] ParamNodePtr FromNode(const yaml::Node& node);
// A value alone, such as one of the command line. Every place is said to be `origin`.
[[nodiscard]] ParamNodePtr FromValue(std::string_view yaml, const ParamOrigin& origin);
// The same value, said by `origin` as a whole.
[[nodiscard]] ParamNodePtr WithOrigin(const ParamNode& node, const ParamOrigin& origin);

// Maps are joined, everything else is replaced by `upper`; an empty value leaves a map as it is.
[[nodiscard]] ParamNodePtr Merged(const ParamNodePtr& lower, const ParamNodePtr& upper);

// `value` stands at `path` afterwards, null: nothing does. Maps on the way are made where nothing is, or an empty
// value. Throws ParamError if the way leads through something else, or beyond the end of a list.
[[nodiscard]] ParamNodePtr With(const ParamNodePtr& root, const ParamPath& path, const ParamNodePtr& value);

[[nodiscard]] ParamNodePtr Find(const ParamNodePtr& root, const ParamPath& path);

// One place at which two trees differ: a value that is no map in either, or that only one of them has.
struct Difference {
  ParamPath path;
  ParamNodePtr before;  // null: nothing
  ParamNodePtr after;
};
// In the order of `after`, then what only `before` has.
[[nodiscard]] std::vector<Difference> Differences(const ParamNodePtr& before, const ParamNodePtr& after);

}  // namespace hgros::param_tree
