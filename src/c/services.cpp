#include "hgros/c/services.h"

#include "c/executors.hpp"
#include "c/handles.hpp"
#include "c/raw.hpp"
#include "c/request_desk.hpp"

struct hgros_service {
  std::shared_ptr<hgros::c::RequestDesk> desk;  // Null with a handler.
  hgros::Service service;
  std::atomic<bool> ended{false};  // With a desk: once `service` is being ended.

  ~hgros_service() {
    if (desk && !desk->in_forked_child()) desk->Stop();  // First: the service's thread may wait for an answer.
  }
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

hgros_status Reply(hgros_reply& reply, Answer answer) {
  if (reply.replied) throw InvalidArgument("The request has its reply already.");
  if (reply.desk && reply.desk->in_forked_child()) return Fail(HGROS_CLOSED, kOfParent);
  if (!reply.desk) {
    reply.answer = std::move(answer);
  } else if (!reply.desk->Reply(reply.number, std::move(answer))) {
    return Fail(HGROS_CLOSED, "The service has ended, and the caller has been told.");
  }
  reply.replied = true;
  return HGROS_OK;
}

Payload Handle(hgros_service_handler handler, const User& user, const RawMessage& request) {
  const hgros_message message(std::make_shared<const RawMessage>(request));
  hgros_reply reply;
  handler(user.get(), &message, &reply);
  return PayloadOf(std::move(reply.answer));
}

NodeOptions NodeOptionsOf(const hgros_serve_options& options, Executor executor) {
  NodeOptions node{std::string(TextOrNone(options.name)), {}, std::move(executor)};
  if (options.most_waiting > 0) node.queue = Queue::KeepAll(static_cast<std::size_t>(options.most_waiting));
  return node;
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_reply_set(hgros_reply* reply, const void* data, size_t size) {
  return c::Guarded([&] {
    hgros_reply& to = c::Given(reply, "reply");
    auto copy = std::make_shared<const std::string>(hgros::AsText(c::Borrowed(data, size).bytes));
    const hgros::Bytes bytes = hgros::AsBytes(*copy);
    return c::Reply(to, {hgros::Payload{bytes, std::move(copy)}, {}});
  });
}

hgros_status hgros_reply_fail(hgros_reply* reply, const char* sentence) {
  return c::Guarded([&] {
    return c::Reply(c::Given(reply, "reply"), {{}, std::string(c::Text(sentence, "sentence"))});
  });
}

void hgros_reply_free(hgros_reply* reply) {
  if (reply == nullptr) return;
  if (!reply->replied) (void)hgros_reply_fail(reply, "The server has dropped the request without a reply.");
  delete reply;
}

hgros_status hgros_serve(hgros_session* session, const char* name, const hgros_schema* request,
                         const hgros_schema* reply, const hgros_serve_options* options, hgros_service_handler handler,
                         void* user, hgros_release release, hgros_service** service) {
  return c::CreatingFor(c::CallbackOf{c::LifeOf(session), {}}, user, release, service,
                        [&](const std::shared_ptr<const c::User>& kept) {
                          const hgros_session& on = c::Opened(session);
                          const std::string_view served = c::Text(name, "name");
                          if (handler == nullptr) c::RefuseNull("handler");
                          const hgros_serve_options chosen = c::OptionsFrom(options);
                          auto made = std::make_unique<hgros_service>();
                          made->service = on.session->ServeRaw(
                              served, c::SchemaIn(request, "request"), c::SchemaIn(reply, "reply"),
                              [handler, kept, life = on.life](const hgros::RawMessage& asked) {
                                const c::InCallback inside(life.get());
                                return c::Handle(handler, *kept, asked);
                              },
                              chosen.concurrent != 0 ? hgros::Invoke::kConcurrent : hgros::Invoke::kSerial,
                              c::NodeOptionsOf(chosen, c::ExecutorOf(chosen.executor)), c::kFromC);
                          return made;
                        });
}

hgros_status hgros_serve_queue(hgros_session* session, const char* name, const hgros_schema* request,
                               const hgros_schema* reply, const hgros_serve_options* options, hgros_service** service) {
  return c::Creating(service, [&] {
    const hgros_session& on = c::Opened(session);
    const std::string_view served = c::Text(name, "name");
    const hgros_serve_options chosen = c::OptionsFrom(options);
    if (chosen.concurrent != 0 || chosen.executor != 0) {
      throw c::InvalidArgument("A service without a handler has set concurrent or executor. Leave them 0.");
    }
    auto made = std::make_unique<hgros_service>();
    made->desk = std::make_shared<c::RequestDesk>(on.life);
    made->service = on.session->ServeRaw(
        served, c::SchemaIn(request, "request"), c::SchemaIn(reply, "reply"),
        [desk = made->desk](const hgros::RawMessage& asked) { return desk->Handle(asked); }, hgros::Invoke::kSerial,
        c::NodeOptionsOf(chosen, hgros::Executor::Dedicated()), c::kFromC);
    on.life->Add(made->desk);
    const hgros::NodeSnapshot node = made->service.stats();
    if (node.executor.kind() != hgros::Executor::Kind::kDedicated) {
      throw hgros::Error("The node \"" + node.name + "\" hands out the requests of service \"" + std::string(served) +
                             "\" and waits for the program, but its configuration has another executor.",
                         {}, "Remove the executor setting, or set `executor: dedicated`.");
    }
    return made;
  });
}

hgros_status hgros_service_take(hgros_service* service, int64_t timeout_ns, hgros_message** request,
                                hgros_reply** reply) {
  if (request != nullptr) *request = nullptr;
  if (reply != nullptr) *reply = nullptr;
  return c::Guarded([&] {
    const hgros_service& of = c::Given(service, "service");
    hgros_message*& taken = c::Given(request, "the place for the request");
    hgros_reply*& place = c::Given(reply, "the place for the reply");
    if (!of.desk) throw c::InvalidArgument("The service has a handler. Use hgros_serve_queue() to take requests.");
    return of.desk->Take(timeout_ns, taken, place);
  });
}

int32_t hgros_service_descriptor(const hgros_service* service) {
  return service == nullptr || !service->desk ? -1 : service->desk->descriptor();
}

void hgros_service_end(hgros_service* service) {
  if (service == nullptr || !service->desk || service->desk->in_forked_child()) return;
  const c::InClose closes;
  service->desk->Stop();
  if (!service->ended.exchange(true)) (void)c::Guarded([&] { service->service.Reset(); });
}

void hgros_service_close(hgros_service* service) {
  const c::InClose closes;
  delete service;
}

hgros_status hgros_wait_for_service(const hgros_session* session, const char* name, int64_t timeout_ns) {
  return c::Guarded([&] {
    const std::string_view service = c::Text(name, "name");
    const hgros_session& on = c::Opened(session);
    if (on.session->WaitForService(service, c::Timeout(timeout_ns))) return hgros_status{HGROS_OK};
    if (on.life->closed()) return c::Fail(HGROS_CLOSED, on.life->why_closed());
    return c::Fail(HGROS_TIMED_OUT, "Nobody serves \"" + std::string(service) + "\".");
  });
}

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
    const auto kept = c::KeepUser(user, release, {c::LifeOf(session), {}});
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
