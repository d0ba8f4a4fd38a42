#include "params/param_tree.hpp"

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "hgros/config/config_sections.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/params_of_document.hpp"
#include "hgros/yaml/scalar_text.hpp"

namespace hgros::param_tree {
namespace {

using Kind = ParamNode::Kind;

bool IsSection(const std::string& key) { return std::ranges::find(kConfigSections, key) != kConfigSections.end(); }

class FromYaml {
 public:
  explicit FromYaml(ParamOrigin origin, bool with_places) : origin_(std::move(origin)), with_places_(with_places) {}

  // Aliases share one node here, too: a file with many aliases must not grow when it is copied.
  ParamNodePtr Make(const yaml::Node& from) {
    const auto made = made_.find(&from);
    if (made != made_.end()) return made->second;
    auto node = std::make_shared<ParamNode>();
    node->kind = from.kind == yaml::Node::Kind::kText   ? Kind::kText
                 : from.kind == yaml::Node::Kind::kList ? Kind::kList
                 : from.kind == yaml::Node::Kind::kMap  ? Kind::kMap
                                                        : Kind::kNull;
    node->text = from.text;
    node->quoted = from.quoted;
    node->origin = origin_;
    if (with_places_) node->origin = {SourceOf(from), from.line, from.column};
    for (const yaml::Node* const item : from.items) node->items.push_back(Make(*item));
    for (const auto& entry : from.entries) node->entries.emplace_back(entry.key->text, Make(*entry.value));
    made_.emplace(&from, node);
    return node;
  }

 private:
  std::shared_ptr<const std::string> SourceOf(const yaml::Node& node) {
    if (file_ != node.file) source_ = std::make_shared<const std::string>(*node.file);
    file_ = node.file;
    return source_;
  }

  ParamOrigin origin_;
  bool with_places_;
  const std::string* file_ = nullptr;          // Of the last node with a place,
  std::shared_ptr<const std::string> source_;  // and a copy.
  std::unordered_map<const yaml::Node*, ParamNodePtr> made_;
};

// The value of `key`, looked for at `guess` first: two versions of a large map mostly have the same order.
ParamNodePtr FindFrom(std::size_t guess, const ParamNode& map, const std::string& key) {
  const bool there = guess < map.entries.size() && map.entries[guess].first == key;
  return there ? map.entries[guess].second : map.Find(key);
}

void Compare(const ParamPath& path, const ParamNodePtr& before, const ParamNodePtr& after,
             std::vector<Difference>& out) {
  if (before == after) return;
  const bool maps = before != nullptr && after != nullptr && before->kind == Kind::kMap && after->kind == Kind::kMap;
  if (!maps) {
    if (before != nullptr && after != nullptr && before->SameValue(*after)) return;
    out.push_back({path, before, after});
    return;
  }
  for (std::size_t i = 0; i < after->entries.size(); ++i) {
    const auto& [key, value] = after->entries[i];
    const ParamNodePtr old = FindFrom(i, *before, key);
    if (old != value) Compare(path.Below(key), old, value, out);
  }
  for (std::size_t i = 0; i < before->entries.size(); ++i) {
    const auto& [key, value] = before->entries[i];
    if (FindFrom(i, *after, key) == nullptr) out.push_back({path.Below(key), value, nullptr});
  }
}

ParamNodePtr WithAt(const ParamNodePtr& node, const ParamPath& path, std::size_t depth, const ParamNodePtr& value) {
  if (depth == path.steps().size()) return value;
  const ParamPath::Step& step = path.steps()[depth];
  const auto fail = [&](std::string_view what) {
    const ParamPath here(std::vector(path.steps().begin(), path.steps().begin() + static_cast<std::ptrdiff_t>(depth)));
    throw ParamError(path.ToString() + " cannot be set: " + (here.empty() ? "the root" : here.ToString()) + " " +
                         std::string(what) + ".",
                     node == nullptr ? std::string() : node->origin.ToString());
  };
  auto changed = std::make_shared<ParamNode>();
  if (node != nullptr) *changed = *node;
  changed->text.clear();  // Of an argument, which this no longer is.
  if (const auto* const index = std::get_if<std::size_t>(&step)) {
    if (node == nullptr || node->kind != Kind::kList) fail("is not a list");
    if (*index >= node->items.size()) fail("has only " + std::to_string(node->items.size()) + " items");
    const ParamNodePtr item = WithAt(node->items[*index], path, depth + 1, value);
    if (item != nullptr) {
      changed->items[*index] = item;
    } else {
      changed->items.erase(changed->items.begin() + static_cast<std::ptrdiff_t>(*index));
    }
    // A list is saved as a whole, so the list gets the origin of the new item.
    if (value != nullptr) changed->origin = value->origin;
    return changed;
  }
  const std::string& key = std::get<std::string>(step);
  if (node == nullptr || node->kind == Kind::kNull) {
    if (value == nullptr) return node;
    changed->kind = Kind::kMap;
    changed->origin = value->origin;
  } else if (node->kind != Kind::kMap) {
    fail("is " + node->Description() + ", not a map");
  }
  const auto entry = std::find_if(changed->entries.begin(), changed->entries.end(),
                                  [&](const auto& candidate) { return candidate.first == key; });
  const bool there = entry != changed->entries.end();
  const ParamNodePtr below = WithAt(there ? entry->second : nullptr, path, depth + 1, value);
  if (below == nullptr) {
    if (there) changed->entries.erase(entry);
  } else if (there) {
    entry->second = below;
  } else {
    changed->entries.emplace_back(key, below);
  }
  return changed;
}

}  // namespace

ParamNodePtr EmptyRoot() {
  auto root = std::make_shared<ParamNode>();
  root->kind = Kind::kMap;
  return root;
}

ParamNodePtr FromDocument(const yaml::Document& document) {
  const yaml::Node& top = document.root();
  if (top.kind == yaml::Node::Kind::kNull) return EmptyRoot();
  ParamNodePtr root = FromYaml({}, true).Make(top);
  if (root->kind == Kind::kMap) return root;
  throw ConfigError("A parameter file must be a map, but this one is " + root->Description() + ".",
                    document.PositionOf(top), "Begin each parameter with its name and a colon.");
}

ParamNodePtr FromNode(const yaml::Node& node) { return FromYaml({}, false).Make(node); }

ParamNodePtr FromValue(std::string_view yaml, const ParamOrigin& origin) {
  const yaml::Document document = yaml::Document::Parse(yaml, origin.ToString());
  return FromYaml(origin, false).Make(document.root());
}

ParamNodePtr FromArgument(const std::string& argument, const std::string& said) {
  const yaml::Document document = yaml::Document::ParseArgument(argument, said);
  return FromYaml({std::make_shared<const std::string>(said)}, false).Make(document.root());
}

ParamNodePtr WithOrigin(const ParamNode& node, const ParamOrigin& origin) {
  auto copy = std::make_shared<ParamNode>(node);
  copy->origin = origin;
  for (ParamNodePtr& item : copy->items) item = WithOrigin(*item, origin);
  for (auto& [key, value] : copy->entries) value = WithOrigin(*value, origin);
  return copy;
}

ParamNodePtr Merged(const ParamNodePtr& lower, const ParamNodePtr& upper) {
  if (lower->kind != Kind::kMap) return upper;
  if (upper->kind == Kind::kNull) return lower;
  if (upper->kind != Kind::kMap) return upper;
  auto merged = std::make_shared<ParamNode>(*lower);
  for (const auto& [key, value] : upper->entries) {
    const auto entry = std::find_if(merged->entries.begin(), merged->entries.end(),
                                    [&key = key](const auto& candidate) { return candidate.first == key; });
    if (entry == merged->entries.end()) {
      merged->entries.emplace_back(key, value);
    } else {
      entry->second = Merged(entry->second, value);
    }
  }
  return merged;
}

ParamNodePtr With(const ParamNodePtr& root, const ParamPath& path, const ParamNodePtr& value) {
  if (path.empty() && (value == nullptr || value->kind != Kind::kMap)) {
    throw ParamError("The root of the parameters must be a map.");
  }
  return WithAt(root, path, 0, value);
}

ParamNodePtr Find(const ParamNodePtr& root, const ParamPath& path) {
  ParamNodePtr node = root;
  for (const ParamPath::Step& step : path.steps()) {
    if (node == nullptr) return nullptr;
    if (const auto* const key = std::get_if<std::string>(&step)) {
      node = node->Find(*key);
    } else {
      const std::size_t index = std::get<std::size_t>(step);
      node = index < node->items.size() ? node->items[index] : nullptr;
    }
  }
  return node;
}

std::vector<std::string> ListBelow(const ParamView& view) {
  std::vector<std::string> paths;
  if (!view.exists()) return paths;
  if (view.node()->kind != ParamNode::Kind::kMap || (view.size() == 0 && !view.path().empty())) {
    paths.push_back(view.path().ToString());
    return paths;
  }
  for (const std::string& key : view.keys()) std::ranges::move(ListBelow(view[key]), std::back_inserter(paths));
  return paths;
}

ParamNodePtr WithoutSession(const ParamNodePtr& root) {
  auto rest = std::make_shared<ParamNode>(*root);
  std::erase_if(rest->entries, [](const auto& entry) { return IsSection(entry.first); });
  return rest;
}

void RequireNotSession(const ParamPath& path) {
  const auto* const key = path.empty() ? nullptr : std::get_if<std::string>(&path.steps().front());
  if (key == nullptr || !IsSection(*key)) return;
  throw ParamError(path.ToString() + " cannot be a parameter: \"" + *key +
                       "\" at the top of a file belongs to the configuration of the session.",
                   {}, "Give it another name, for example below a section of your own.");
}

std::vector<Difference> Differences(const ParamNodePtr& before, const ParamNodePtr& after) {
  std::vector<Difference> differences;
  Compare({}, before, after, differences);
  return differences;
}

}  // namespace hgros::param_tree

namespace hgros {

ParamNodePtr ParamsOf(const yaml::Document& document) { return param_tree::FromDocument(document); }

}  // namespace hgros
