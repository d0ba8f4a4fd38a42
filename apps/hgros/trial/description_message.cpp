#include "trial/description_message.hpp"

#include <string>
#include <utility>
#include <vector>

namespace hgros::cli {
namespace {

void Write(const std::vector<ComponentChannel>& channels,
           google::protobuf::RepeatedPtrField<TrialStep::Channel>& written) {
  for (const ComponentChannel& one : channels) {
    TrialStep::Channel& to = *written.Add();
    to.set_name(one.name);
    to.set_channel(one.channel);
    to.set_type(one.type);
    to.set_node(one.node);
  }
}

void Write(const std::vector<ComponentService>& services,
           google::protobuf::RepeatedPtrField<TrialStep::Service>& written) {
  for (const ComponentService& one : services) {
    TrialStep::Service& to = *written.Add();
    to.set_name(one.name);
    to.set_service(one.service);
    to.set_request(one.request);
    to.set_reply(one.reply);
  }
}

std::vector<ComponentChannel> Read(const google::protobuf::RepeatedPtrField<TrialStep::Channel>& channels) {
  std::vector<ComponentChannel> read;
  for (const TrialStep::Channel& one : channels) read.push_back({one.name(), one.channel(), one.type(), one.node()});
  return read;
}

std::vector<ComponentService> Read(const google::protobuf::RepeatedPtrField<TrialStep::Service>& services) {
  std::vector<ComponentService> read;
  for (const TrialStep::Service& one : services) {
    read.push_back({one.name(), one.service(), one.request(), one.reply()});
  }
  return read;
}

}  // namespace

TrialStep::Made MessageOf(const ComponentDescription& description) {
  TrialStep::Made made;
  made.set_name(description.name);
  made.set_type(description.type);
  Write(description.inputs, *made.mutable_inputs());
  Write(description.outputs, *made.mutable_outputs());
  Write(description.services, *made.mutable_services());
  Write(description.calls, *made.mutable_calls());
  for (const ComponentTimer& one : description.timers) {
    TrialStep::Timer& to = *made.add_timers();
    to.set_name(one.name);
    to.set_period_ns(one.period.count());
  }
  for (const ParamDeclaration& one : description.params) {
    TrialStep::Param& to = *made.add_params();
    to.set_path(one.path);
    to.set_description(one.info.description);
    to.set_unit(one.info.unit);
    if (one.info.least) to.set_least(*one.info.least);
    if (one.info.most) to.set_most(*one.info.most);
    for (const std::string& choice : one.info.choices) to.add_choices(choice);
    to.set_read_only(one.info.read_only);
    to.set_type(one.type);
    to.set_fallback(one.fallback);
  }
  made.set_transforms(description.transforms);
  made.set_state(description.state);
  for (const auto& [type, fingerprint] : description.fingerprints) {
    TrialStep::Fingerprint& to = *made.add_fingerprints();
    to.set_type(type);
    to.set_value(fingerprint);
  }
  return made;
}

ComponentDescription DescriptionFrom(const TrialStep::Made& made) {
  ComponentDescription description;
  description.name = made.name();
  description.type = made.type();
  description.inputs = Read(made.inputs());
  description.outputs = Read(made.outputs());
  description.services = Read(made.services());
  description.calls = Read(made.calls());
  for (const TrialStep::Timer& one : made.timers()) {
    description.timers.push_back({one.name(), Duration(one.period_ns())});
  }
  for (const TrialStep::Param& one : made.params()) {
    ParamInfo info{one.description(), one.unit(), {}, {}, {one.choices().begin(), one.choices().end()},
                   one.read_only()};
    if (one.has_least()) info.least = one.least();
    if (one.has_most()) info.most = one.most();
    description.params.push_back({one.path(), std::move(info), one.type(), one.fallback()});
  }
  description.transforms = made.transforms();
  description.state = made.state();
  for (const TrialStep::Fingerprint& one : made.fingerprints())
    description.fingerprints.emplace(one.type(), one.value());
  return description;
}

}  // namespace hgros::cli
