package hgros

// #include "bridge.h"
import "C"

import (
	"fmt"
	"runtime"
	"strings"
	"sync"
)

// Code is the kind of a failure. It is an error itself, so that errors.Is(err, hgros.Full) works.
type Code int32

// The codes of the library (hgros/c/status.h).
const (
	InvalidArgument Code = C.HGROS_INVALID_ARGUMENT
	Failed          Code = C.HGROS_ERROR
	TypeMismatch    Code = C.HGROS_TYPE_MISMATCH
	ConfigError     Code = C.HGROS_CONFIG_ERROR
	Closed          Code = C.HGROS_CLOSED
	Full            Code = C.HGROS_FULL
	TimedOut        Code = C.HGROS_TIMED_OUT
	WouldDeadlock   Code = C.HGROS_WOULD_DEADLOCK
	TooLarge        Code = C.HGROS_TOO_LARGE
	NoMemory        Code = C.HGROS_NO_MEMORY
	NotFound        Code = C.HGROS_NOT_FOUND
	Refused         Code = C.HGROS_REFUSED
	NoServer        Code = C.HGROS_NO_SERVER
	HandlerFailed   Code = C.HGROS_HANDLER_FAILED
	ServerGone      Code = C.HGROS_SERVER_GONE
	Cancelled       Code = C.HGROS_CANCELLED
	NotWritable     Code = C.HGROS_NOT_WRITABLE
	UnknownFrame    Code = C.HGROS_UNKNOWN_FRAME
	NotConnected    Code = C.HGROS_NOT_CONNECTED
	TooOld          Code = C.HGROS_TOO_OLD
	TooNew          Code = C.HGROS_TOO_NEW
)

// Error is the name of the code, such as "full".
func (c Code) Error() string { return C.GoString(C.hgros_status_name(C.hgros_status(c))) }

// Error is what every function of the package returns when the library refuses.
type Error struct {
	Code     Code
	Sentence string // What went wrong, where, and how to mend it.
}

func (e *Error) Error() string { return "hgros: " + e.Code.Error() + ": " + e.Sentence }

// Unwrap makes errors.Is compare codes.
func (e *Error) Unwrap() error { return e.Code }

// uncut refuses texts that C would cut.
func uncut(what string, texts ...string) error {
	for _, text := range texts {
		if strings.IndexByte(text, 0) >= 0 {
			return &Error{InvalidArgument,
				fmt.Sprintf("%s is %q, but a text must not have the character U+0000.", what, text)}
		}
	}
	return nil
}

// check runs one call of the library and reads its sentence on the same thread, where the library keeps it.
func check(call func() C.hgros_status) error {
	runtime.LockOSThread()
	defer runtime.UnlockOSThread()
	if status := call(); status != C.HGROS_OK {
		return &Error{Code(status), C.GoString(C.hgros_last_error())}
	}
	return nil
}

// guard lets a handle be closed while others use it: the last one out frees it.
type guard struct {
	mutex  sync.Mutex
	users  int
	closed bool
	free   func()
}

func (g *guard) enter(what string) error {
	g.mutex.Lock()
	defer g.mutex.Unlock()
	if g.closed {
		return &Error{Closed, "The " + what + " is closed."}
	}
	g.users++
	return nil
}

func (g *guard) leave() {
	g.mutex.Lock()
	g.users--
	last := g.closed && g.users == 0
	g.mutex.Unlock()
	if last {
		g.free()
	}
}

// close is false if it was closed before.
func (g *guard) close() bool {
	g.mutex.Lock()
	if g.closed {
		g.mutex.Unlock()
		return false
	}
	g.closed = true
	last := g.users == 0
	g.mutex.Unlock()
	if last {
		g.free()
	}
	return true
}

func (g *guard) do(what string, call func() C.hgros_status) error {
	if err := g.enter(what); err != nil {
		return err
	}
	defer g.leave()
	return check(call)
}

// outside does it here, or inside a callback on a goroutine: what is closed may wait for the callback.
func outside(do func()) {
	if C.GoInCallback() > 0 {
		go do()
	} else {
		do()
	}
}

// closeWith closes what the library refuses to close inside callbacks: there, a goroutine does it.
func (g *guard) closeWith(call func() C.hgros_status) error {
	var failure error
	free := func() {
		err := check(call)
		g.mutex.Lock()
		defer g.mutex.Unlock()
		failure, g.closed = err, err == nil
	}
	g.mutex.Lock()
	g.free = func() { outside(free) }
	g.mutex.Unlock()
	g.close()
	g.mutex.Lock()
	defer g.mutex.Unlock()
	return failure
}
