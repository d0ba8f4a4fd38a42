#pragma once

#include "hgros/c/message.h"
#include "hgros/c/session.h"

// Subscribing. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// Receives a channel, with a callback or through a queue.
typedef struct hgros_subscription hgros_subscription;

/// Gets a message, valid until the callback returns: hgros_message_keep() keeps it.
typedef void (*hgros_message_callback)(void* user, const hgros_message* message);

enum {
  HGROS_EXECUTOR_WORKERS = 0,   ///< Worker threads of the session: for callbacks of any length.
  HGROS_EXECUTOR_INLINE = 1,    ///< The thread that delivers: lowest latency; keep the callback short.
  HGROS_EXECUTOR_DEDICATED = 2  ///< A thread of its own.
};

typedef struct hgros_subscribe_options {
  size_t size;
  const char* name;            ///< For logs, tables and configuration; NULL: channel and number.
  const hgros_schema* schema;  ///< The expected type; NULL: any. Messages of another type are not delivered: they are
                               ///< counted as mismatched, and the log names both types and the sender once.
  uint64_t keep_last;          ///< Newest messages that may wait, older ones are dropped and counted; 0: 16.
  uint64_t keep_all;           ///< Not 0: lossless, with room for this many. Publishers get HGROS_FULL meanwhile.
  uint64_t keep_all_bytes;     ///< For keep_all: also at most about this many bytes; 0: no limit.
  int32_t concurrent;          ///< The callback may run any number of times at once; otherwise one by one, in order.
  int32_t executor;            ///< HGROS_EXECUTOR_...; not for queues.
} hgros_subscribe_options;

/// Calls `callback` with every message on `channel`, until the subscription is closed. `options` may be NULL.
/// Errors: HGROS_TYPE_MISMATCH if this session uses the channel with another type than `options->schema`; HGROS_ERROR
/// if the name cannot be used.
hgros_status hgros_subscribe(hgros_session* session, const char* channel, const hgros_subscribe_options* options,
                             hgros_message_callback callback, void* user, hgros_release release,
                             hgros_subscription** subscription);

/// The same without a callback: messages wait until they are taken. Nothing in the configuration replaces that.
hgros_status hgros_subscribe_queue(hgros_session* session, const char* channel, const hgros_subscribe_options* options,
                                   hgros_subscription** subscription);
/// Takes the oldest message of a queue, which the caller frees. Any number of threads; each message goes to one. With a
/// timeout of 0 it may be called for each event of the descriptor.
/// Errors: HGROS_TIMED_OUT if none came; HGROS_CLOSED once the subscription or its session has ended.
hgros_status hgros_queue_take(hgros_subscription* queue, int64_t timeout_ns, hgros_message** message);
/// A descriptor that is readable while messages wait, and once the queue has ended: for poll(), epoll and event loops.
/// Neither read, write nor close it. Valid as long as the handle. -1 for a subscription with a callback, and for NULL.
int32_t hgros_queue_descriptor(const hgros_subscription* queue);

/// Counters since the subscription began.
typedef struct hgros_subscription_stats {
  size_t size;
  uint64_t received;          ///< Messages that reached it, including those dropped later.
  uint64_t dropped;           ///< Removed from a full keep-last queue.
  uint64_t run;               ///< Callbacks that returned, or messages that were taken.
  uint64_t queued;            ///< Waiting now.
  uint64_t mismatched;        ///< Not delivered: of another type than hgros_subscribe_options.schema.
  int64_t queue_wait_p50_ns;  ///< From publishing to the callback: median,
  int64_t queue_wait_p99_ns;  ///< and the time that 1 % exceed.
} hgros_subscription_stats;

/// Fills in `stats`. Once the subscription has ended, all but `mismatched` are 0.
hgros_status hgros_subscription_get_stats(const hgros_subscription* subscription, hgros_subscription_stats* stats);

/// Ends the subscription and wakes threads that wait in hgros_queue_take(); the handle stays. May be called while other
/// threads use it. Outside callbacks of its session it waits for its running callbacks.
void hgros_subscription_end(hgros_subscription* subscription);
/// Ends it and frees the handle. May be called inside its own callback.
void hgros_subscription_close(hgros_subscription* subscription);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
