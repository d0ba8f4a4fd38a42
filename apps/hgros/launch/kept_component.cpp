#include "launch/kept_component.hpp"

#include <utility>

#include "hgros/base/bytes.hpp"

namespace hgros::cli {

void KeptComponent::Note(const RunReport::Changed& changed) {
  if (changed.path().empty()) {
    params.clear();
  } else {
    params[changed.path()] = changed.value();
  }
}

ComponentSetup KeptComponent::Continue(ComponentSetup setup) const {
  if (state != nullptr) setup.state = state;
  for (const auto& [path, value] : params) setup.params.overrides.push_back({path, value, "hgros param set " + path});
  return setup;
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
