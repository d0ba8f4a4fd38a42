#include "hgros/component/raw_context.hpp"

#include <utility>

#include "component/context_core.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros {

const std::string& RawContext::type() const noexcept { return context_.core_.setup().type; }

void RawContext::AddInput(std::string_view channel, const MessageSchema& schema, Invoke invoke, AnyCallback callback,
                          NodeOptions options, const CallSite& where) {
  context_.AddInput({channel, RunTimeType(schema), invoke, where}, std::move(callback), std::move(options));
}

std::string RawContext::Serve(std::string_view service, const MessageSchema& request, const MessageSchema& reply,
                              RawHandler handler, Invoke invoke, NodeOptions options, const CallSite& where) {
  const TypeInfo& body = RunTimeType(reply);
  context_.AddService(
      {service, RunTimeCallType(request), RunTimeCallType(reply), RunTimeType(request), body, invoke, where},
      SessionParts::HandlerOf(std::move(handler), body), std::move(options));
  return context_.core_.NameHere(service);
}

RawServiceClient RawContext::Client(std::string_view service, const MessageSchema& request,
                                    const MessageSchema& reply) {
  return {context_.session(), context_.AddCalled(service, RunTimeType(request), RunTimeType(reply)), request, reply};
}

}  // namespace hgros
