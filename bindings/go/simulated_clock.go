package hgros

// #include "bridge.h"
import "C"

import "time"

// SimulatedClock is a clock that all sessions of the domain with `time: simulated` follow, including the one that
// publishes it.
type SimulatedClock struct {
	guard
	handle  *C.hgros_simulated_clock
	session *Session // Not forgotten while its clock is used.
}

// NewSimulatedClock publishes a clock that shows a time. If it is paused, only Step advances it at first; otherwise it
// runs at rate 1. Publish one clock at a time.
func (s *Session) NewSimulatedClock(start time.Time, paused bool) (*SimulatedClock, error) {
	clock := &SimulatedClock{session: s}
	if err := s.do("session", func() C.hgros_status {
		return C.hgros_simulated_clock_open(s.handle, C.int64_t(start.UnixNano()), truth(paused), &clock.handle)
	}); err != nil {
		return nil, err
	}
	return clock, nil
}

// Close ends the clock: those that follow it stand still. Inside a callback it does not wait for it, as Params.Close.
func (c *SimulatedClock) Close() error {
	return c.closeWith(func() C.hgros_status { return C.hgros_simulated_clock_close(c.handle) })
}

// Now is what it shows; the zero Time once it is closed.
func (c *SimulatedClock) Now() time.Time {
	if c.enter("simulated clock") != nil {
		return time.Time{}
	}
	defer c.leave()
	return time.Unix(0, int64(C.hgros_simulated_clock_now(c.handle)))
}

func (c *SimulatedClock) change(call func() C.hgros_status) error {
	return c.do("simulated clock", call)
}

// Step lets time pass at once: everything planned within it becomes due, in order. It must not be negative.
func (c *SimulatedClock) Step(passed time.Duration) error {
	return c.change(func() C.hgros_status { return C.hgros_simulated_clock_step(c.handle, C.int64_t(passed)) })
}

// Jump makes it show a time from now on. Timers move along with it.
func (c *SimulatedClock) Jump(to time.Time) error {
	return c.change(func() C.hgros_status { return C.hgros_simulated_clock_jump(c.handle, C.int64_t(to.UnixNano())) })
}

// SetRate sets the seconds of this clock per second, which must be above zero and finite.
func (c *SimulatedClock) SetRate(rate float64) error {
	return c.change(func() C.hgros_status { return C.hgros_simulated_clock_set_rate(c.handle, C.double(rate)) })
}

// Pause stops it until Resume.
func (c *SimulatedClock) Pause() error {
	return c.change(func() C.hgros_status { return C.hgros_simulated_clock_pause(c.handle) })
}

// Resume lets it run on at its rate.
func (c *SimulatedClock) Resume() error {
	return c.change(func() C.hgros_status { return C.hgros_simulated_clock_resume(c.handle) })
}
