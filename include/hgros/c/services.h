#pragma once

#include "hgros/c/message.h"
#include "hgros/c/session.h"

// Services, in both roles. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// Offers a service.
typedef struct hgros_service hgros_service;
/// The place for the reply to one request. That of a handler is valid until the handler returns.
typedef struct hgros_reply hgros_reply;

/// Handles a request on a thread of the library. It calls one of the two functions below, once, on this thread.
typedef void (*hgros_service_handler)(void* user, const hgros_message* request, hgros_reply* reply);
/// Replies with a copy of the bytes. Errors of both: HGROS_INVALID_ARGUMENT if the request has its reply already;
/// HGROS_CLOSED if it was taken and the service has ended meanwhile.
hgros_status hgros_reply_set(hgros_reply* reply, const void* data, size_t size);
/// The caller gets HGROS_HANDLER_FAILED with this sentence.
hgros_status hgros_reply_fail(hgros_reply* reply, const char* sentence);

typedef struct hgros_serve_options {
  size_t size;
  const char* name;       ///< Of the node, for logs and configuration; NULL: the service's.
  uint64_t most_waiting;  ///< Requests that may wait; further ones fail with HGROS_FULL. 0: 16384.
  int32_t concurrent;     ///< Any number of requests may be handled at once.
  int32_t executor;       ///< HGROS_EXECUTOR_... of hgros/c/subscribe.h.
} hgros_serve_options;

/// Serves `name`, for callers in this session and in others. `options` may be NULL.
/// Errors: HGROS_ERROR if this session serves it already, or if the name or a schema cannot be used.
hgros_status hgros_serve(hgros_session* session, const char* name, const hgros_schema* request,
                         const hgros_schema* reply, const hgros_serve_options* options, hgros_service_handler handler,
                         void* user, hgros_release release, hgros_service** service);
/// Requests that wait fail. Outside callbacks it waits for the running handlers.
void hgros_service_close(hgros_service* service);

/// The same without a handler, for programs that cannot be called by threads of the library: requests wait until they
/// are taken. They are handed out one at a time: the next one once the reply to the last one is set. A request whose
/// caller's timeout is over is not handed out; the session's snapshot counts it (unhandled_requests). `concurrent` and
/// `executor` must be 0. Errors: also HGROS_ERROR if the configuration gives the service's node another executor.
hgros_status hgros_serve_queue(hgros_session* session, const char* name, const hgros_schema* request,
                               const hgros_schema* reply, const hgros_serve_options* options, hgros_service** service);
/// Takes the oldest request, which the caller frees as any message, and the place for its reply: any thread calls
/// hgros_reply_set() or hgros_reply_fail() on it once, then hgros_reply_free(). A thread that takes requests must not
/// call its own service meanwhile: it would wait for itself until the call times out.
/// Errors: HGROS_TIMED_OUT if none came; HGROS_CLOSED once the service or its session has ended.
hgros_status hgros_service_take(hgros_service* service, int64_t timeout_ns, hgros_message** request,
                                hgros_reply** reply);
/// A descriptor that is readable while a request can be taken, and once the service has ended. Neither read, write nor
/// close it. Valid as long as the handle. -1 for a service with a handler, and for NULL.
int32_t hgros_service_descriptor(const hgros_service* service);
/// Frees a place that hgros_service_take() has given. The caller of a request without a reply gets
/// HGROS_HANDLER_FAILED.
void hgros_reply_free(hgros_reply* reply);
/// Ends a service without a handler and wakes threads that wait in hgros_service_take(): requests that wait fail with
/// HGROS_SERVER_GONE, also one that was taken and has no reply, and callers no longer find it. The handle stays. May be
/// called while other threads use it.
void hgros_service_end(hgros_service* service);

/// Waits until this session serves `name`, or knows another one that does: a call finds it then. Errors:
/// HGROS_TIMED_OUT, HGROS_CLOSED; HGROS_ERROR if no service can have that name.
hgros_status hgros_wait_for_service(const hgros_session* session, const char* name, int64_t timeout_ns);

/// Calls the service `name` with a copy of the bytes and waits for the reply, which the caller frees. `reply_schema`:
/// the expected type; NULL: any. Inside a callback the thread meanwhile handles requests of its own session, so that it
/// does not wait for itself.
/// Errors: HGROS_NO_SERVER, HGROS_TIMED_OUT, HGROS_HANDLER_FAILED, HGROS_SERVER_GONE, HGROS_TYPE_MISMATCH, HGROS_FULL,
/// HGROS_NOT_WRITABLE, HGROS_WOULD_DEADLOCK, HGROS_CLOSED; HGROS_ERROR if no service can have that name.
hgros_status hgros_call(hgros_session* session, const char* name, const hgros_schema* request_schema, const void* data,
                        size_t size, const hgros_schema* reply_schema, int64_t timeout_ns, hgros_message** reply);

/// A call whose reply comes to a callback.
typedef struct hgros_pending_call hgros_pending_call;

/// The end of a call: HGROS_OK and the reply, or a status, NULL and a sentence. Called once, on a thread of the
/// library, or on the thread that ends or closes the session.
typedef void (*hgros_reply_callback)(void* user, hgros_status status, const char* sentence, const hgros_message* reply);

/// As hgros_call(), but does not wait. `call` may be NULL if nobody cancels. If this function fails, the callback is
/// not called.
hgros_status hgros_call_later(hgros_session* session, const char* name, const hgros_schema* request_schema,
                              const void* data, size_t size, const hgros_schema* reply_schema, int64_t timeout_ns,
                              hgros_reply_callback callback, void* user, hgros_release release,
                              hgros_pending_call** call);
/// Ends the call with HGROS_CANCELLED, unless it has ended.
void hgros_call_cancel(hgros_pending_call* call);
/// Frees the handle; the call goes on.
void hgros_call_free(hgros_pending_call* call);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
