#include "launch/kept_component.hpp"

#include <optional>
#include <utility>

#include "hgros/base/bytes.hpp"

namespace hgros::cli {
namespace {

std::string SaidOf(const std::string& path) { return "hgros param set " + path; }

}  // namespace

void KeptComponent::Note(const RunReport::Changed& changed) {
  if (changed.path().empty()) {
    params.clear();
  } else {
    params[changed.path()] = changed.value();
  }
}

ComponentSetup KeptComponent::Continue(ComponentSetup setup) const {
  if (state != nullptr) setup.state = state;
  for (const auto& [path, value] : params) setup.params.overrides.push_back({path, value, SaidOf(path)});
  return setup;
}

std::vector<ParamChange> KeptComponent::ChangesSince(const KeptComponent& earlier) const {
  std::vector<ParamChange> changes;
  for (const auto& [path, value] : params) {
    const auto found = earlier.params.find(path);
    if (found != earlier.params.end() && found->second == value) continue;
    if (value.empty()) {
      changes.push_back({path, std::nullopt});
    } else {
      const ParamServer reader({.overrides = {{"value", value, SaidOf(path)}}});
      const ParamNodePtr node = reader["value"].node();
      changes.push_back({path, node == nullptr ? ParamNode() : *node});
    }
  }
  return changes;
}

void Write(const KeptComponent& kept, RunOrder::Move& move) {
  if (kept.state != nullptr) *move.mutable_state() = ReportOf(move.component(), *kept.state).saved();
  for (const auto& [path, value] : kept.params) {
    RunReport::Changed& changed = *move.add_params();
    changed.set_path(path);
    changed.set_value(value);
  }
}

KeptComponent KeptOf(const RunOrder::Move& move) {
  KeptComponent kept;
  if (move.has_state()) kept.state = StateOf(move.state());
  for (const RunReport::Changed& changed : move.params()) kept.params[changed.path()] = changed.value();
  return kept;
}

RunReport ReportOf(const std::string& component, const RawMessage& state) {
  RunReport report;
  RunReport::Saved& saved = *report.mutable_saved();
  saved.set_component(component);
  saved.set_type(state.schema->type_name);
  saved.set_encoding(static_cast<int>(state.schema->encoding));
  saved.set_fingerprint(state.schema->fingerprint);
  saved.set_descriptor_set(state.schema->descriptor_set);
  saved.set_data(std::string(AsText(state.data.bytes)));
  return report;
}

std::shared_ptr<const RawMessage> StateOf(const RunReport::Saved& saved) {
  auto schema = std::make_shared<MessageSchema>();
  schema->type_name = saved.type();
  schema->encoding = static_cast<Encoding>(saved.encoding());
  schema->fingerprint = saved.fingerprint();
  schema->descriptor_set = saved.descriptor_set();
  auto data = std::make_shared<const std::string>(saved.data());
  return std::make_shared<const RawMessage>(RawMessage{std::move(schema), {AsBytes(*data), data}});
}

}  // namespace hgros::cli
