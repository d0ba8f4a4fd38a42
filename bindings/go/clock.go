package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"runtime/cgo"
	"time"
	"unsafe"
)

// Now is the session's clock: the wall clock, or with `time: simulated` the one that is published. The zero Time once
// the session is closed.
func (s *Session) Now() time.Time {
	if s.enter("session") != nil {
		return time.Time{}
	}
	defer s.leave()
	return time.Unix(0, int64(C.hgros_session_now(s.handle)))
}

// Tick is one turn of a timer.
type Tick struct {
	Planned time.Time // The planned moment, without drift.
	Now     time.Time // The time of the session's clock.
	Missed  uint64    // Moments before the planned one that were skipped.
}

// TimerOptions are read when a timer is made. nil is the default.
type TimerOptions struct {
	First   time.Duration // Time to the first turn; 0: one period.
	CatchUp bool          // Missed turns are run late, one right after the other; otherwise only the latest one.
}

// Timer calls a function periodically until it or its session is closed.
type Timer struct {
	guard
	handle  *C.hgros_timer
	session *Session
}

// NewTimer calls a function every period of the session's clock, one call at a time, on a thread of the session. The
// name is that of its node, for logs and configuration.
func (s *Session) NewTimer(name string, period time.Duration, turn func(Tick), options *TimerOptions) (*Timer, error) {
	if turn == nil {
		return nil, &Error{InvalidArgument, "The function of the timer \"" + name + "\" is nil."}
	}
	if err := uncut("The name of the timer", name); err != nil {
		return nil, err
	}
	text := C.CString(name)
	defer C.free(unsafe.Pointer(text))
	var chosen TimerOptions
	if options != nil {
		chosen = *options
	}
	timer := &Timer{session: s}
	if err := s.do("session", func() C.hgros_status {
		return C.GoTimerOpen(s.handle, text, C.int64_t(period), C.int64_t(chosen.First), truth(chosen.CatchUp),
			C.uintptr_t(cgo.NewHandle(turn)), &timer.handle)
	}); err != nil {
		return nil, err
	}
	timer.free = func() { C.hgros_timer_close(timer.handle) }
	s.keep(timer)
	return timer, nil
}

// Close ends the timer: no call comes after it. Outside callbacks it waits for the running one.
func (t *Timer) Close() {
	t.session.forget(t)
	t.close()
}

//export hgrosGoTick
func hgrosGoTick(user C.uintptr_t, tick *C.hgros_tick) {
	turn := cgo.Handle(user).Value().(func(Tick))
	turn(Tick{time.Unix(0, int64(tick.planned_ns)), time.Unix(0, int64(tick.now_ns)), uint64(tick.missed)})
}

// SleepUntil sleeps until the session's clock shows a time, following its jumps and pauses. It holds a thread. The error
// is Closed once the session has ended.
func (s *Session) SleepUntil(due time.Time) error {
	return s.do("session", func() C.hgros_status {
		return C.hgros_session_sleep_until(s.handle, C.int64_t(due.UnixNano()))
	})
}
