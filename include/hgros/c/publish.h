#pragma once

#include "hgros/c/message.h"
#include "hgros/c/session.h"

// Publishing. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// Publishes messages of one type on one channel.
typedef struct hgros_publisher hgros_publisher;

typedef struct hgros_publish_options {
  size_t size;
  uint64_t latched;  ///< Number of recent messages kept for late subscribers.
} hgros_publish_options;

/// Announces a channel. `options` may be NULL. Errors: HGROS_TYPE_MISMATCH if this session uses the channel with
/// another type; HGROS_ERROR if the name or the schema cannot be used. Another session with another type is reported in
/// the log and by hgros_watch_peers().
hgros_status hgros_publisher_open(hgros_session* session, const char* channel, const hgros_schema* schema,
                                  const hgros_publish_options* options, hgros_publisher** publisher);
void hgros_publisher_close(hgros_publisher* publisher);

/// Publishes a copy of the bytes to all subscribers, in the order of the calls. Never waits. On any status except
/// HGROS_OK nobody got the message. Bytes are not parsed here: subscribers drop and count what is not of its type.
/// Errors: HGROS_FULL, HGROS_CLOSED, HGROS_TOO_LARGE, HGROS_NO_MEMORY.
hgros_status hgros_publish(const hgros_publisher* publisher, const void* data, size_t size);
/// The same, but waits while a lossless subscriber has no room. Errors: also HGROS_TIMED_OUT, and HGROS_WOULD_DEADLOCK
/// inside a callback.
hgros_status hgros_publish_wait(const hgros_publisher* publisher, const void* data, size_t size, int64_t timeout_ns);
/// Publishes the caller's bytes without a copy inside this process. Nobody may write or free them until `release` is
/// called with `user`, by any thread, perhaps before this returns. After HGROS_FULL, HGROS_TIMED_OUT and
/// HGROS_WOULD_DEADLOCK it is not called: the bytes are the caller's again, who may publish them once more. After any
/// other status it is. `timeout_ns` as in hgros_publish_wait(); with 0 it never waits.
hgros_status hgros_publish_borrowed(const hgros_publisher* publisher, const void* data, size_t size, void* user,
                                    hgros_release release, int64_t timeout_ns);

/// Memory to fill and publish. It is where receivers on this host read, so publishing it copies nothing.
typedef struct hgros_loan hgros_loan;

/// A loan for one message of `size` bytes, which have arbitrary values at first. Never waits: without subscribers on
/// this host, or if the shared memory is full, it is ordinary memory. Errors: HGROS_CLOSED, HGROS_NO_MEMORY.
hgros_status hgros_loan_open(const hgros_publisher* publisher, size_t size, hgros_loan** loan);
/// The bytes to fill; NULL once they are published. `size` may be NULL. One thread at a time.
void* hgros_loan_data(hgros_loan* loan, size_t* size);
/// Publishes the loan on the channel of its publisher. After HGROS_OK nobody may write the bytes; after another status
/// the loan is as it was. `timeout_ns` and errors as in hgros_publish_wait(), and HGROS_INVALID_ARGUMENT if it is
/// published already. With 0 it never waits and returns HGROS_FULL.
hgros_status hgros_loan_publish(hgros_loan* loan, int64_t timeout_ns);
/// Frees the handle. A published message is not affected.
void hgros_loan_free(hgros_loan* loan);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
