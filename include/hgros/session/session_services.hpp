#pragma once

#include <chrono>
#include <concepts>
#include <functional>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/services/call_future.hpp"
#include "hgros/services/service.hpp"

namespace hgros {

class SessionCore;

/// Returns the bytes of a reply, which are copied if they have no owner. If it throws, the caller gets
/// CallFailure::kHandlerFailed.
using RawHandler = std::function<Payload(const RawMessage& request)>;

/// The services that a Session offers and calls. Use it as a part of Session, which documents threading.
class HGROS_EXPORT SessionServices {
 public:
  /// Serves `name`: `handler` is called with each request and returns its reply. Callers may be in this session
  /// (request and reply are passed by pointer) and in others. If it throws, the caller gets
  /// CallFailure::kHandlerFailed.
  ///
  /// Threading: as a subscription's callback. Under kSerial, too, a thread that waits for a reply inside a callback of
  ///            this session may handle a request (see CallFuture::Wait).
  /// Ordering:  under kSerial, one caller's requests in the order in which they came, except for those that such a
  ///            thread takes first.
  /// Limits:    the number of requests that may wait is the size of the options' queue if that is lossless, else 16384.
  ///            Further requests fail with CallFailure::kFull.
  /// Errors:    throws Error if this session serves the name already.
  template <class Request, class Reply, HandlerFor<Request, Reply> F>
  [[nodiscard("requests are handled only while the Service lives")]] Service Serve(
      std::string_view name, F&& handler, Invoke invoke = Invoke::kSerial, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    return ServeAny(name, {CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Request>(), TypeOf<Reply>()},
                    EraseHandler<Request, Reply>(std::forward<F>(handler)), invoke, std::move(options), where);
  }
  /// The same with types that are only known at run time. Callers may be typed or raw, in this session and in others.
  /// Bytes are not parsed here: a reply that its caller cannot read ends that call with CallFailure::kNotWritable.
  /// Errors: as Serve, and Error if a schema does not name a type; see RunTimeType().
  [[nodiscard("requests are handled only while the Service lives")]] Service ServeRaw(
      std::string_view name, const MessageSchema& request, const MessageSchema& reply, RawHandler handler,
      Invoke invoke = Invoke::kSerial, NodeOptions options = {}, const CallSite& where = CallSite::Current());

  /// Calls the service `name` of this session, or else of the session with that service that was found first. `request`
  /// is a Request, or a unique_ptr or shared_ptr to one. Only the first call of a name may block, because it wires the
  /// service.
  ///
  /// Errors: returned as CallFailure. Throws Error only if no service can have that name.
  template <class Request, class Reply, class M>
  [[nodiscard]] CallFuture<Reply> Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout) {
    return CallFuture<Reply>(CallTyped<Request, Reply>(name, std::forward<M>(request), timeout, {}));
  }
  /// The same; `callback` is called once with the result, on a worker of the graph. For calls that are left when the
  /// session ends, the thread that ends it calls `callback`. What it throws is logged.
  template <class Request, class Reply, class M, std::invocable<const CallResult<Reply>&> F>
  CallTicket Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout, F&& callback) {
    return CallTicket(
        CallTyped<Request, Reply>(name, std::forward<M>(request), timeout, AnswerTo<Reply>(std::forward<F>(callback))));
  }
  /// Calls with the bytes of a request whose type is known at run time only. The server may be typed or raw, in this
  /// session or in another. A `reply` that does not name a type accepts any; the result has the actual type. Bytes of
  /// the request without an owner are copied; bytes with an owner must not be written any more.
  /// Errors: as Call, and Error if `request_schema` does not name a type; see RunTimeType().
  [[nodiscard]] CallFuture<RawMessage> CallRaw(std::string_view name, const MessageSchema& request_schema,
                                               const Payload& request, const MessageSchema& reply,
                                               std::chrono::nanoseconds timeout);
  /// The same with a callback. With Executor::Inline(), the thread that ends the call calls it at once, even if no
  /// worker is free. That may be a thread of the session: so it must not wait, and only hands the result to another
  /// one. Errors: also Error for Executor::Dedicated().
  template <std::invocable<const CallResult<RawMessage>&> F>
  CallTicket CallRaw(std::string_view name, const MessageSchema& request_schema, const Payload& request,
                     const MessageSchema& reply, std::chrono::nanoseconds timeout, F&& callback,
                     const Executor& executor = Executor::Tbb()) {
    return CallTicket(CallBytes(name, request_schema, request, reply, timeout,
                                AnswerTo<RawMessage>(std::forward<F>(callback)), executor));
  }

  /// Waits until this session serves `name`, or knows another one that does: a Call finds it then. False if `timeout`
  /// came first, or if the session is ending. Do not call it in callbacks.
  /// Errors: throws Error if no service can have that name.
  [[nodiscard]] bool WaitForService(std::string_view name, std::chrono::nanoseconds timeout) const;

 protected:
  explicit SessionServices(SessionCore& core) noexcept : services_core_(core) {}
  ~SessionServices() = default;

 private:
  friend class SessionParts;
  // The types of the two channels, then the types of the messages.
  struct CallTypes {
    const TypeInfo& request;
    const TypeInfo& reply;
    const TypeInfo& request_body;
    const TypeInfo& reply_body;
  };
  template <class Reply, class F>
  static AnyAnswer AnswerTo(F&& callback) {
    return [shared = std::make_shared<std::decay_t<F>>(std::forward<F>(callback))](const CallEnd& end) {
      (*shared)(CallResult<Reply>(end));
    };
  }
  template <class Request, class Reply, class M>
  std::shared_ptr<PendingCall> CallTyped(std::string_view name, M&& request, std::chrono::nanoseconds timeout,
                                         AnyAnswer callback) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    return CallAny(name, {CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Request>(), TypeOf<Reply>()},
                   ShareRequest<Request>(std::forward<M>(request)), timeout, std::move(callback));
  }
  std::shared_ptr<PendingCall> CallBytes(std::string_view name, const MessageSchema& request_schema,
                                         const Payload& request, const MessageSchema& reply,
                                         std::chrono::nanoseconds timeout, AnyAnswer callback,
                                         const Executor& executor);
  Service ServeAny(std::string_view name, const CallTypes& types, AnyHandler handler, Invoke invoke,
                   NodeOptions options, const CallSite& where);
  std::shared_ptr<PendingCall> CallAny(std::string_view name, const CallTypes& types, AnyMessage request,
                                       std::chrono::nanoseconds timeout, AnyAnswer callback,
                                       bool answers_inline = false);

  SessionCore& services_core_;
};

}  // namespace hgros
