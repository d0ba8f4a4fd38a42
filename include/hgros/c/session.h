#pragma once

#include "hgros/c/status.h"

// Sessions. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// One participant of the hypergraph. A process may have several; they then talk as two processes do. A forked child
/// cannot use a session of its parent.
typedef struct hgros_session hgros_session;

enum { HGROS_LOG_DEBUG = 0, HGROS_LOG_INFO = 1, HGROS_LOG_WARNING = 2, HGROS_LOG_ERROR = 3 };

/// Gets the library's log: a whole sentence without a line break. Called by any thread, one call at a time. It must not
/// call the library.
typedef void (*hgros_log_callback)(void* user, int32_t level, const char* text);

typedef struct hgros_session_options {
  size_t size;
  const char* name;        ///< For logs and other sessions' tables; NULL: the program's name.
  hgros_log_callback log;  ///< NULL: standard error.
  void* log_user;
  hgros_release log_release;
} hgros_session_options;

/// Opens a session with a configuration as YAML text (docs/configuration.md). `yaml` NULL or empty: that of the
/// variable HGROS_CONFIG, or the default, which finds the sessions of this user on this host; HGROS_DOMAIN is the
/// domain. `options` may be NULL. Errors: HGROS_CONFIG_ERROR; HGROS_ERROR if an endpoint cannot be bound or a name
/// cannot be used.
hgros_status hgros_session_open(const char* yaml, const hgros_session_options* options, hgros_session** session);

/// The same with `count` files, which are merged.
hgros_status hgros_session_open_files(const char* const* files, size_t count, const hgros_session_options* options,
                                      hgros_session** session);

/// Ends the session's use: all threads that wait for it, or for what was made from it, return with HGROS_CLOSED, and so
/// does every later call, except for those of its log, and of counters. A call of hgros_session_wait_idle() that waits
/// already returns once no callback runs. Calls that are pending end, perhaps with their callbacks on this thread,
/// which must not close the session. Other callbacks may still run until hgros_session_close(), before which the handle
/// stays valid. Does not wait. Any thread, also inside callbacks: use it where one thread ends what others wait for,
/// then join them, then close.
void hgros_session_end(hgros_session* session);

/// Refuses what is published from now on, waits for running callbacks, and says goodbye to the other sessions. What was
/// published is still sent; for a lossless subscriber that takes nothing it waits half a second. Ends all that was made
/// from the session; those handles must still be closed.
/// Inside a callback of the session it does not wait: it says goodbye, and the rest stays until the process ends, with
/// a line in the log.
void hgros_session_close(hgros_session* session);

/// The session's name. Valid as long as the session.
const char* hgros_session_name(const hgros_session* session);
/// The session's id, as hgros_message_info.publisher has it; 0 for NULL.
uint64_t hgros_session_id(const hgros_session* session);

/// Waits until no message is queued and no callback runs, provided that no message comes meanwhile. Messages in queues
/// without a callback do not count. A request of hgros_serve_queue() counts until it has its reply. Errors:
/// HGROS_TIMED_OUT; HGROS_WOULD_DEADLOCK inside a callback.
hgros_status hgros_session_wait_idle(const hgros_session* session, int64_t timeout_ns);

/// Writes a line into the session's log. Control characters are the caller's concern. Errors: HGROS_CLOSED in a forked
/// child.
hgros_status hgros_session_log(const hgros_session* session, int32_t level, const char* text);
/// The same for lines that may repeat, such as those of failed callbacks. `alike` names lines that are alike: ten of
/// them are written, but the same one only once in 10 s; then one in 10 s, in 20 s, and so on. A line says how many
/// were held back before it. Give few such names: only the latest 1024 are remembered, the library's own among them,
/// each for an hour. Errors: HGROS_CLOSED in a forked child.
hgros_status hgros_session_log_limited(const hgros_session* session, int32_t level, const char* alike,
                                       const char* text);
/// Lines below `level` are not written from now on.
hgros_status hgros_session_set_log_level(const hgros_session* session, int32_t level);

/// Waits until `channel` has at least `count` subscribers in this session and others together; they get what is
/// published after that. The channel must have a publisher of this session. Errors: HGROS_TIMED_OUT, HGROS_CLOSED.
hgros_status hgros_session_wait_for_subscribers(const hgros_session* session, const char* channel, size_t count,
                                                int64_t timeout_ns);
/// Waits until at least `count` other sessions that publish on `channel` are connected. Errors: HGROS_TIMED_OUT,
/// HGROS_CLOSED.
hgros_status hgros_session_wait_for_publishers(const hgros_session* session, const char* channel, size_t count,
                                               int64_t timeout_ns);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
