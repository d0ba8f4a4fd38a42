#include "params/param_wire.hpp"

#include <memory>

#include "hgros/base/names.hpp"
#include "params/param_tree.hpp"
#include "params/yaml_writing.hpp"

namespace hgros::param_wire {

Channels::Channels(std::string_view name) {
  const std::string prefix = "params/" + std::string(name);
  ask = prefix + "/ask";
  answer = prefix + "/answer";
  state = prefix + "/state";
  RequireChannelName(answer);
}

void WriteValues(const ParamView& root, ParamsState& state) {
  state.set_yaml(root.size() == 0 ? std::string() : yaml_writing::Entries(*root.node(), 0));
}

ParamNodePtr ReadValues(const ParamsState& state, const std::string& name) {
  return param_tree::FromDocument(yaml::Document::Parse(state.yaml(), name));
}

void WriteDeclarations(const std::vector<ParamDeclaration>& declarations, ParamsState& state) {
  for (const ParamDeclaration& declaration : declarations) {
    ParamsDeclaration& to = *state.add_declared();
    const ParamInfo& info = declaration.info;
    to.set_path(declaration.path);
    to.set_description(info.description);
    to.set_unit(info.unit);
    if (info.least) to.set_least(*info.least);
    if (info.most) to.set_most(*info.most);
    for (const std::string& choice : info.choices) to.add_choices(choice);
    to.set_read_only(info.read_only);
    to.set_type(declaration.type);
    to.set_fallback(declaration.fallback);
  }
}

std::vector<ParamDeclaration> ReadDeclarations(const ParamsState& state) {
  std::vector<ParamDeclaration> declarations;
  for (const ParamsDeclaration& from : state.declared()) {
    ParamDeclaration& to = declarations.emplace_back();
    to.path = from.path();
    to.info.description = from.description();
    to.info.unit = from.unit();
    if (from.has_least()) to.info.least = from.least();
    if (from.has_most()) to.info.most = from.most();
    to.info.choices.assign(from.choices().begin(), from.choices().end());
    to.info.read_only = from.read_only();
    to.type = from.type();
    to.fallback = from.fallback();
  }
  return declarations;
}

void WriteChanges(const std::vector<ParamChange>& changes, ParamsQuestion& question) {
  for (const ParamChange& change : changes) {
    ParamsChange& to = *question.add_changes();
    to.set_path(change.path);
    if (change.value) to.set_yaml(yaml_writing::Inline(*change.value));
    to.set_remove(!change.value);
  }
}

std::vector<ParamChange> ReadChanges(const ParamsQuestion& question) {
  std::vector<ParamChange> changes;
  for (const ParamsChange& from : question.changes()) {
    ParamChange& to = changes.emplace_back();
    to.path = from.path();
    if (from.remove()) continue;
    const ParamOrigin origin{std::make_shared<const std::string>("the request for " + from.path())};
    to.value = *param_tree::FromValue(from.yaml(), origin);
  }
  return changes;
}

}  // namespace hgros::param_wire
