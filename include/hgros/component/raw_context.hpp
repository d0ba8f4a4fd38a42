#pragma once

#include <chrono>
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/context.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// Calls one service with types that are known at run time only. Copies are cheap.
class RawServiceClient {
 public:
  /// For RawContext. `service` is the robot's name for it.
  RawServiceClient(Session& session, std::string service, MessageSchema request, MessageSchema reply)
      : session_(&session), service_(std::move(service)), request_(std::move(request)), reply_(std::move(reply)) {}

  /// The robot's name for it.
  [[nodiscard]] const std::string& service() const noexcept { return service_; }

  /// As Session::CallRaw.
  template <std::invocable<const CallResult<RawMessage>&> F>
  CallTicket Call(const Payload& request, std::chrono::nanoseconds timeout, F&& callback,
                  const Executor& executor = Executor::Tbb()) const {
    return session_->CallRaw(service_, request_, request, reply_, timeout, std::forward<F>(callback), executor);
  }

 private:
  Session* session_;
  std::string service_;
  MessageSchema request_;
  MessageSchema reply_;
};

/// What a Context offers for types that are known at run time only: for components of other languages.
///
/// Threading and errors: as Context.
class HGROS_EXPORT RawContext {
 public:
  explicit RawContext(Context& context) noexcept : context_(context) {}

  /// The name of the component's type, such as "slam2d/Mapper".
  [[nodiscard]] const std::string& type() const noexcept;
  /// As Context::FromAny, for messages of one type. Their bytes are not parsed here.
  template <CallbackFor<RawMessage> F>
  void FromAny(std::string_view channel, const MessageSchema& schema, Invoke invoke, F&& callback,
               NodeOptions options = {}, const CallSite& where = CallSite::Current()) {
    AddInput(channel, schema, invoke, EraseCallback<RawMessage>(std::forward<F>(callback)), std::move(options), where);
  }
  /// As Context::Serve. Returns the robot's name for the service.
  std::string Serve(std::string_view service, const MessageSchema& request, const MessageSchema& reply,
                    RawHandler handler, Invoke invoke = Invoke::kSerial, NodeOptions options = {},
                    const CallSite& where = CallSite::Current());
  /// As Context::Client.
  [[nodiscard]] RawServiceClient Client(std::string_view service, const MessageSchema& request,
                                        const MessageSchema& reply);

 private:
  void AddInput(std::string_view channel, const MessageSchema& schema, Invoke invoke, AnyCallback callback,
                NodeOptions options, const CallSite& where);

  Context& context_;
};

}  // namespace hgros
