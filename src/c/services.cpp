#include "hgros/c/services.h"

#include <optional>
#include <stdexcept>

#include "c/executors.hpp"
#include "c/handles.hpp"
#include "c/raw.hpp"

struct hgros_service {
  hgros::Service service;
};

struct hgros_reply {
  std::optional<hgros::Payload> data;
  std::optional<std::string> failure;
};

struct hgros_pending_call {
  hgros::CallTicket ticket;
};

namespace hgros::c {
namespace {

using RawResult = CallResult<RawMessage>;

hgros_status StatusOf(CallFailure::Kind kind) noexcept {
  switch (kind) {
    case CallFailure::Kind::kNoServer: return HGROS_NO_SERVER;
    case CallFailure::Kind::kTimedOut: return HGROS_TIMED_OUT;
    case CallFailure::Kind::kHandlerFailed: return HGROS_HANDLER_FAILED;
    case CallFailure::Kind::kServerGone: return HGROS_SERVER_GONE;
    case CallFailure::Kind::kTypeMismatch: return HGROS_TYPE_MISMATCH;
    case CallFailure::Kind::kFull: return HGROS_FULL;
    case CallFailure::Kind::kCancelled: return HGROS_CANCELLED;
    case CallFailure::Kind::kWouldDeadlock: return HGROS_WOULD_DEADLOCK;
    case CallFailure::Kind::kNotWritable: return HGROS_NOT_WRITABLE;
    case CallFailure::Kind::kClosed: return HGROS_CLOSED;
  }
  return HGROS_ERROR;
}

MessageSchema SchemaOrAny(const hgros_schema* schema) { return schema == nullptr ? MessageSchema{} : *schema->schema; }

void RequireOpen(const hgros_reply& reply) {
  if (reply.data || reply.failure) throw InvalidArgument("The request has its reply already.");
}

// The graph passes the sentence of an exception on to the caller.
Payload Handle(hgros_service_handler handler, const User& user, const RawMessage& request) {
  const hgros_message message(std::make_shared<const RawMessage>(request));
  hgros_reply reply;
  handler(user.get(), &message, &reply);
  if (reply.failure) throw std::runtime_error(*reply.failure);
  if (!reply.data) throw std::runtime_error("The handler has set no reply.");
  return *std::move(reply.data);
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_reply_set(hgros_reply* reply, const void* data, size_t size) {
  return c::Guarded([&] {
    c::RequireOpen(c::Given(reply, "reply"));
    auto copy = std::make_shared<const std::string>(hgros::AsText(c::Borrowed(data, size).bytes));
    const hgros::Bytes bytes = hgros::AsBytes(*copy);
    reply->data = hgros::Payload{bytes, std::move(copy)};
  });
}

hgros_status hgros_reply_fail(hgros_reply* reply, const char* sentence) {
  return c::Guarded([&] {
    c::RequireOpen(c::Given(reply, "reply"));
    reply->failure = c::Text(sentence, "sentence");
  });
}

hgros_status hgros_serve(hgros_session* session, const char* name, const hgros_schema* request,
                         const hgros_schema* reply, const hgros_serve_options* options, hgros_service_handler handler,
                         void* user, hgros_release release, hgros_service** service) {
  return c::CreatingFor(user, release, service, [&](const std::shared_ptr<const c::User>& kept) {
    const hgros_session& on = c::Opened(session);
    const std::string_view served = c::Text(name, "name");
    if (handler == nullptr) c::RefuseNull("handler");
    const hgros_serve_options chosen = c::OptionsFrom(options);
    hgros::NodeOptions node{std::string(c::TextOrNone(chosen.name)), {}, c::ExecutorOf(chosen.executor)};
    if (chosen.most_waiting > 0) node.queue = hgros::Queue::KeepAll(static_cast<std::size_t>(chosen.most_waiting));
    return std::make_unique<hgros_service>(hgros_service{on.session->ServeRaw(
        served, c::SchemaIn(request, "request"), c::SchemaIn(reply, "reply"),
        [handler, kept, life = on.life](const hgros::RawMessage& asked) {
          const c::InCallback inside(life.get());
          return c::Handle(handler, *kept, asked);
        },
        chosen.concurrent != 0 ? hgros::Invoke::kConcurrent : hgros::Invoke::kSerial, std::move(node), c::kFromC)});
  });
}

void hgros_service_close(hgros_service* service) { delete service; }

hgros_status hgros_call(hgros_session* session, const char* name, const hgros_schema* request_schema, const void* data,
                        size_t size, const hgros_schema* reply_schema, int64_t timeout_ns, hgros_message** reply) {
  if (reply != nullptr) *reply = nullptr;
  return c::Guarded([&] {
    hgros_message*& place = c::Given(reply, "the place for the reply");
    const auto future = c::Opened(session).session->CallRaw(
        c::Text(name, "name"), c::SchemaIn(request_schema, "request_schema"), c::Borrowed(data, size),
        c::SchemaOrAny(reply_schema), c::Timeout(timeout_ns));
    const c::RawResult result = future.Wait();
    if (!result) return c::Fail(c::StatusOf(result.failure().kind), result.failure().reason);
    place = c::NewLease(result.reply()).release();
    return hgros_status{HGROS_OK};
  });
}

hgros_status hgros_call_later(hgros_session* session, const char* name, const hgros_schema* request_schema,
                              const void* data, size_t size, const hgros_schema* reply_schema, int64_t timeout_ns,
                              hgros_reply_callback callback, void* user, hgros_release release,
                              hgros_pending_call** call) {
  if (call != nullptr) *call = nullptr;
  return c::Guarded([&] {
    const auto kept = c::KeepUser(user, release);
    hgros_session& on = c::Opened(session);
    if (callback == nullptr) c::RefuseNull("callback");
    auto made = call == nullptr ? nullptr : std::make_unique<hgros_pending_call>();
    auto ticket = on.session->CallRaw(c::Text(name, "name"), c::SchemaIn(request_schema, "request_schema"),
                                      c::Borrowed(data, size), c::SchemaOrAny(reply_schema), c::Timeout(timeout_ns),
                                      [callback, kept, life = on.life](const c::RawResult& result) {
                                        const c::InCallback inside(life.get());
                                        if (!result) {
                                          const hgros::CallFailure& failure = result.failure();
                                          return callback(kept->get(), c::StatusOf(failure.kind),
                                                          failure.reason.c_str(), nullptr);
                                        }
                                        const hgros_message message(result.reply());
                                        callback(kept->get(), HGROS_OK, "", &message);
                                      });
    if (call == nullptr) return;
    made->ticket = std::move(ticket);
    *call = made.release();
  });
}

void hgros_call_cancel(hgros_pending_call* call) {
  if (call != nullptr) call->ticket.Cancel();
}

void hgros_call_free(hgros_pending_call* call) { delete call; }
