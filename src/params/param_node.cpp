#include "hgros/params/param_node.hpp"

#include <algorithm>

#include "hgros/base/error.hpp"
#include "hgros/yaml/quoted.hpp"
#include "hgros/yaml/scalar_text.hpp"

namespace hgros {

std::string ParamOrigin::ToString() const {
  return source == nullptr ? std::string() : FilePosition{*source, line, column}.ToString();
}

ParamNode ParamNode::Text(std::string text, bool quoted) {
  ParamNode node;
  node.kind = Kind::kText;
  node.text = std::move(text);
  node.quoted = quoted;
  return node;
}

ParamNode ParamNode::List(std::vector<ParamNode> items) {
  ParamNode node;
  node.kind = Kind::kList;
  for (ParamNode& item : items) node.items.push_back(std::make_shared<const ParamNode>(std::move(item)));
  return node;
}

ParamNode ParamNode::Map(std::vector<std::pair<std::string, ParamNode>> entries) {
  ParamNode node;
  node.kind = Kind::kMap;
  for (auto& [key, value] : entries) {
    node.entries.emplace_back(std::move(key), std::make_shared<const ParamNode>(std::move(value)));
  }
  return node;
}

ParamNodePtr ParamNode::Find(std::string_view key) const {
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.first == key; });
  return found == entries.end() ? nullptr : found->second;
}

bool ParamNode::IsString() const { return kind == Kind::kText && (quoted || scalar::IsPlainString(text)); }

std::string ParamNode::Description() const {
  switch (kind) {
    case Kind::kNull: return "empty";
    case Kind::kList: return "a list of " + std::to_string(items.size());
    case Kind::kMap: return "a map";
    case Kind::kText: break;
  }
  if (IsString()) return "the text " + yaml::Quoted(text) + (scalar::IsPlainString(text) ? "" : " in quotes");
  return scalar::Boolean(text) ? text : "the number " + text;
}

bool ParamNode::SameValue(const ParamNode& other) const {
  if (this == &other) return true;
  if (kind != other.kind || items.size() != other.items.size() || entries.size() != other.entries.size()) return false;
  if (kind == Kind::kText) return text == other.text && IsString() == other.IsString();
  const auto same_item = [](const ParamNodePtr& a, const ParamNodePtr& b) { return a == b || a->SameValue(*b); };
  if (!std::equal(items.begin(), items.end(), other.items.begin(), same_item)) return false;
  return std::all_of(entries.begin(), entries.end(), [&](const auto& entry) {
    const ParamNodePtr value = other.Find(entry.first);
    return value != nullptr && same_item(value, entry.second);
  });
}

}  // namespace hgros
