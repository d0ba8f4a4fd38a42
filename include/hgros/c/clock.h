#pragma once

#include "hgros/c/session.h"

// Clocks and timers. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// The wall clock, in ns since 1970. It may jump.
int64_t hgros_wall_now(void);
/// CLOCK_MONOTONIC: for intervals. Never jumps; equal in all processes of a host.
int64_t hgros_monotonic_now(void);
/// The session's clock: the wall clock, or with `time: simulated` the one that is published. 0 for NULL.
int64_t hgros_session_now(const hgros_session* session);
/// Sleeps until the session's clock shows `due_ns`, following its jumps and pauses. Errors: HGROS_CLOSED once
/// hgros_session_end() is called.
hgros_status hgros_session_sleep_until(const hgros_session* session, int64_t due_ns);

/// A callback that is called periodically.
typedef struct hgros_timer hgros_timer;

/// One turn, valid until the callback returns.
typedef struct hgros_tick {
  size_t size;
  int64_t planned_ns;  ///< The planned moment, without drift.
  int64_t now_ns;      ///< The clock's time.
  uint64_t missed;     ///< Moments before the planned one that were skipped.
} hgros_tick;
typedef void (*hgros_timer_callback)(void* user, const hgros_tick* tick);

typedef struct hgros_timer_options {
  size_t size;
  int64_t first_ns;  ///< Time to the first turn; 0: one period.
  int32_t catch_up;  ///< Missed turns are run late, one right after the other; otherwise only the latest one.
  int32_t executor;  ///< HGROS_EXECUTOR_... of hgros/c/subscribe.h.
} hgros_timer_options;

/// Calls `callback` every `period_ns` of the session's clock, one call at a time, as a node named `name`. `options` may
/// be NULL. Errors: HGROS_ERROR if the period is not above zero, or if a timer of the session has the name.
hgros_status hgros_timer_open(hgros_session* session, const char* name, int64_t period_ns,
                              const hgros_timer_options* options, hgros_timer_callback callback, void* user,
                              hgros_release release, hgros_timer** timer);
/// No call comes after it. Outside callbacks it waits for the running one. May be called inside its own callback.
void hgros_timer_close(hgros_timer* timer);

/// A simulated clock, which all sessions of the domain with `time: simulated` follow, including this one.
typedef struct hgros_simulated_clock hgros_simulated_clock;

/// Publishes a clock that shows `start_ns`. If `paused`, only hgros_simulated_clock_step() advances it at first;
/// otherwise it runs at rate 1. Publish one clock at a time. What it shows, and the sum of its jumps, is less than 2^62
/// ns (146 years) away from 0, as those that follow it demand; otherwise the functions below return
/// HGROS_INVALID_ARGUMENT. Errors: HGROS_TYPE_MISMATCH if the channel "clock" has another type.
hgros_status hgros_simulated_clock_open(hgros_session* session, int64_t start_ns, int32_t paused,
                                        hgros_simulated_clock** clock);
/// The clocks that follow it stand still. Errors: HGROS_WOULD_DEADLOCK inside a callback of the session; then nothing
/// is closed.
hgros_status hgros_simulated_clock_close(hgros_simulated_clock* clock);
/// Its time; 0 for NULL and once it has ended.
int64_t hgros_simulated_clock_now(hgros_simulated_clock* clock);
/// Lets time pass at once: everything planned within it becomes due, in order. Errors: HGROS_ERROR if it is negative.
hgros_status hgros_simulated_clock_step(hgros_simulated_clock* clock, int64_t time_ns);
/// Shows `time_ns` from now on: a jump, which timers move along with.
hgros_status hgros_simulated_clock_jump(hgros_simulated_clock* clock, int64_t time_ns);
/// Seconds of this clock per second. Errors: HGROS_ERROR unless it is above zero, up to a million.
hgros_status hgros_simulated_clock_set_rate(hgros_simulated_clock* clock, double rate);
hgros_status hgros_simulated_clock_pause(hgros_simulated_clock* clock);
hgros_status hgros_simulated_clock_resume(hgros_simulated_clock* clock);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
