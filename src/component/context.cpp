#include "hgros/component/context.hpp"

#include <utility>

#include <hgros/SimulatedTime.pb.h>

#include "component/context_core.hpp"
#include "hgros/session/clock_publisher.hpp"

namespace hgros {

const std::string& Context::name() const noexcept { return core_.setup().name; }

RawPublisher Context::AdvertiseRaw(std::string_view channel, const MessageSchema& schema, PublishOptions options,
                                   const CallSite& where) {
  return session().AdvertiseRaw(core_.AddOutput(channel, schema.type_name, schema.fingerprint), schema, options, where);
}

void Context::CreateTimer(std::string_view timer, Duration period, TimerCallback callback, NodeTimerOptions options) {
  core_.AddTimer(timer, period, std::move(callback), std::move(options));
}

const std::shared_ptr<Clock>& Context::clock() const noexcept { return core_.session().clock(); }
std::unique_ptr<ClockPublisher> Context::PublishClock(std::shared_ptr<SimulatedClock> clock) {
  if (AddOutput(kClockChannel, TypeOf<SimulatedTime>()) != kClockChannel) {
    throw Error("The channel \"" + std::string(kClockChannel) + "\" cannot be renamed: all sessions follow that one.");
  }
  return std::make_unique<ClockPublisher>(session(), std::move(clock));
}
ParamServer& Context::params() noexcept { return core_.params(); }
Transforms& Context::transforms() { return core_.UseTransforms(); }
Log& Context::log() noexcept { return core_.log(); }

void Context::Finish(std::string result) { core_.EndBySelf(ComponentState::kFinished, std::move(result)); }
void Context::Fail(std::string sentence) { core_.EndBySelf(ComponentState::kFailed, std::move(sentence)); }

Session& Context::session() noexcept { return core_.session(); }
bool Context::NoteFault(std::string_view param, const ParamError& fault) { return core_.NoteFault(param, fault); }
std::string Context::NameHere(std::string_view name) { return core_.NameHere(name); }
std::string Context::AddOutput(std::string_view channel, const TypeInfo& type) {
  return core_.AddOutput(channel, type.name, type.fingerprint);
}
std::string Context::AddCalled(std::string_view service, const TypeInfo& request, const TypeInfo& reply) {
  return core_.AddCalled(service, request, reply);
}
void Context::AddInput(const ComponentInput& input, AnyCallback callback, NodeOptions options) {
  core_.AddInput(input, std::move(callback), std::move(options));
}
void Context::AddService(const ServedByComponent& served, AnyHandler handler, NodeOptions options) {
  core_.AddService(served, std::move(handler), std::move(options));
}

}  // namespace hgros
