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
/// The reply that a handler makes. Valid until the handler returns.
typedef struct hgros_reply hgros_reply;

/// Handles a request on a thread of the library. It calls one of the two functions below, once, on this thread.
typedef void (*hgros_service_handler)(void* user, const hgros_message* request, hgros_reply* reply);
/// Replies with a copy of the bytes.
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
