#include "hgros/params/param_view.hpp"

#include <algorithm>
#include <span>

#include "hgros/base/names.hpp"
#include "hgros/yaml/quoted.hpp"
#include "params/yaml_edit.hpp"
#include "params/yaml_writing.hpp"

namespace hgros {
namespace {

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

ParamView ParamView::operator[](std::string_view key) const {
  return {node_ == nullptr ? nullptr : node_->Find(key), path_.Below(std::string(key))};
}

ParamView ParamView::operator[](std::size_t index) const {
  const bool there = node_ != nullptr && index < node_->items.size();
  return {there ? node_->items[index] : nullptr, path_.Below(index)};
}

ParamView ParamView::At(const ParamPath& path) const {
  ParamView view = *this;
  for (const ParamPath::Step& step : path.steps()) {
    if (const auto* const key = std::get_if<std::string>(&step)) {
      view = view[*key];
    } else {
      view = view[std::get<std::size_t>(step)];
    }
  }
  return view;
}

std::size_t ParamView::size() const noexcept {
  return node_ == nullptr ? 0 : std::max(node_->items.size(), node_->entries.size());
}

std::vector<std::string> ParamView::keys() const {
  std::vector<std::string> keys;
  if (node_ == nullptr) return keys;
  for (const auto& [key, value] : node_->entries) keys.push_back(key);
  return keys;
}

std::string ParamView::ToYaml() const {
  if (node_ == nullptr) throw ParamError("The parameter " + path_.ToString() + " is not set.");
  if (node_->kind == ParamNode::Kind::kMap && !node_->entries.empty()) return WrittenYaml(node_, path_.ToString());
  const ParamNodePtr file = std::make_shared<ParamNode>(ParamNode::Map({{"value", *node_}}));
  (void)WrittenYaml(file, path_.ToString());
  return yaml_writing::Inline(*node_);
}

void ParamView::FailType(std::string_view wanted, std::string_view mend) const {
  const std::string name = path_.empty() ? "The root of the parameters" : path_.ToString();
  if (node_ == nullptr) {
    throw ParamError("The parameter " + name + " is not set; it must be " + std::string(wanted) + ".", {},
                     mend.empty() ? "Set it, or read it with a default." : mend);
  }
  throw ParamError(name + " must be " + std::string(wanted) + ", but is " + node_->Description() + ".",
                   node_->origin.ToString(), mend);
}

void ParamView::RequireList(std::string_view wanted) const {
  if (node_ == nullptr || node_->kind != ParamNode::Kind::kList) FailType(wanted);
}

void ParamView::RequireMap(std::string_view wanted) const {
  if (node_ == nullptr || (node_->kind != ParamNode::Kind::kMap && node_->kind != ParamNode::Kind::kNull)) {
    FailType(wanted);
  }
}

void ParamView::RequireKeys(const std::vector<std::string>& known) const {
  if (node_ == nullptr) return;
  for (const auto& [key, value] : node_->entries) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string nearest = key.size() <= 64 ? NearestName(key, known) : std::string();
    throw ParamError(
        "Unknown key " + yaml::Quoted(key) + " in " + path_.ToString() + ".", value->origin.ToString(),
        (nearest.empty() ? "" : "Did you mean \"" + nearest + "\"? ") + "Known keys: " + Listed(known) + ".");
  }
}

}  // namespace hgros
