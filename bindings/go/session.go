// Package hgros is the binding of HyperGraph ROS for Go: sessions, typed and raw messages, queues, services.
//
// It is a layer over the C interface (hgros/hgros.h). Waits take a context. Failures are *Error with a Code.
package hgros

// #cgo pkg-config: hgros_c
// #cgo CFLAGS: -std=c99
// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"context"
	"runtime/cgo"
	"sync"
	"time"
	"unsafe"
)

// Level is the weight of a line of the log.
type Level int32

// The levels of the log.
const (
	LogDebug   Level = C.HGROS_LOG_DEBUG
	LogInfo    Level = C.HGROS_LOG_INFO
	LogWarning Level = C.HGROS_LOG_WARNING
	LogError   Level = C.HGROS_LOG_ERROR
)

// SessionOptions are read by Open and OpenFiles. The zero value is the default.
type SessionOptions struct {
	Name string                         // For logs and other sessions' tables; empty: the program's name.
	Log  func(level Level, line string) // Gets the log instead of standard error. It must not call this package.
}

// Session is one participant of the hypergraph.
type Session struct {
	guard
	handle *C.hgros_session
	freed  chan struct{}

	childrenMutex sync.Mutex
	children      map[interface{ Close() }]struct{}
}

// Open opens a session with a configuration as YAML text. Empty: the default, which finds the sessions of this user on
// this host.
func Open(yaml string, options *SessionOptions) (*Session, error) {
	if err := uncut("The configuration", yaml); err != nil {
		return nil, err
	}
	text := C.CString(yaml)
	defer C.free(unsafe.Pointer(text))
	return open(text, nil, 0, options)
}

// OpenFiles opens a session with configuration files, which are merged.
func OpenFiles(files []string, options *SessionOptions) (*Session, error) {
	if err := uncut("The path of a file", files...); err != nil {
		return nil, err
	}
	list, release := textList(files)
	defer release()
	return open(nil, list, len(files), options)
}

func open(yaml *C.char, files **C.char, count int, options *SessionOptions) (*Session, error) {
	session := &Session{freed: make(chan struct{}), children: map[interface{ Close() }]struct{}{}}
	var name *C.char
	var log cgo.Handle
	if options != nil {
		if err := uncut("The name of the session", options.Name); err != nil {
			return nil, err
		}
	}
	if options != nil && options.Name != "" {
		name = C.CString(options.Name)
		defer C.free(unsafe.Pointer(name))
	}
	if options != nil && options.Log != nil {
		log = cgo.NewHandle(options.Log)
	}
	if err := check(func() C.hgros_status {
		return C.GoSessionOpen(yaml, files, C.size_t(count), name, C.uintptr_t(log), &session.handle)
	}); err != nil {
		return nil, err
	}
	free := func() {
		C.hgros_session_close(session.handle)
		close(session.freed)
	}
	session.free = func() { outside(free) }
	return session, nil
}

// End wakes all that wait for the session, and every later call returns Closed. It does not wait; it may be called
// inside handlers. Call Close later.
func (s *Session) End() {
	if s.enter("session") == nil {
		C.hgros_session_end(s.handle)
		s.leave()
	}
}

// Close ends the session, waits for running callbacks, and says goodbye to the other sessions. Inside a callback it does
// not wait: what is left is done once the callback has returned. A callback must not wait for a goroutine that closes.
func (s *Session) Close() {
	s.End()
	outside(s.finish)
}

func (s *Session) finish() {
	s.close()
	<-s.freed
	s.childrenMutex.Lock()
	children := s.children
	s.children = nil
	s.childrenMutex.Unlock()
	for child := range children {
		child.Close()
	}
}

// keep makes a child live until it is closed or its session is, which may be so already.
func (s *Session) keep(child interface{ Close() }) {
	s.childrenMutex.Lock()
	ended := s.children == nil
	if !ended {
		s.children[child] = struct{}{}
	}
	s.childrenMutex.Unlock()
	if ended {
		child.Close()
	}
}

func (s *Session) forget(child interface{ Close() }) {
	s.childrenMutex.Lock()
	defer s.childrenMutex.Unlock()
	delete(s.children, child)
}

// ID is the session's id, as Info.Publisher of its messages has it; 0 once it is closed.
func (s *Session) ID() uint64 {
	if s.enter("session") != nil {
		return 0
	}
	defer s.leave()
	return uint64(C.hgros_session_id(s.handle))
}

// Log writes a line into the session's log.
func (s *Session) Log(level Level, line string) error {
	if err := uncut("The line for the log", line); err != nil {
		return err
	}
	text := C.CString(line)
	defer C.free(unsafe.Pointer(text))
	return s.do("session", func() C.hgros_status { return C.hgros_session_log(s.handle, C.int32_t(level), text) })
}

// WaitForSubscribers waits until a channel that this session publishes has at least count subscribers.
func (s *Session) WaitForSubscribers(ctx context.Context, channel string, count int) error {
	if err := uncut("The name of the channel", channel); err != nil {
		return err
	}
	name := C.CString(channel)
	defer C.free(unsafe.Pointer(name))
	return poll(ctx, func(timeout C.int64_t) error {
		return s.do("session", func() C.hgros_status {
			return C.hgros_session_wait_for_subscribers(s.handle, name, C.size_t(count), timeout)
		})
	})
}

// WaitForPublishers waits until at least count other sessions that publish on a channel are connected.
func (s *Session) WaitForPublishers(ctx context.Context, channel string, count int) error {
	if err := uncut("The name of the channel", channel); err != nil {
		return err
	}
	name := C.CString(channel)
	defer C.free(unsafe.Pointer(name))
	return poll(ctx, func(timeout C.int64_t) error {
		return s.do("session", func() C.hgros_status {
			return C.hgros_session_wait_for_publishers(s.handle, name, C.size_t(count), timeout)
		})
	})
}

// poll makes a wait of the library end with the context: the library waits in slices, which nothing else cuts short.
func poll(ctx context.Context, wait func(timeout C.int64_t) error) error {
	const slice = 50 * time.Millisecond
	for {
		if err := ctx.Err(); err != nil {
			return err
		}
		timeout := remaining(ctx)
		if timeout == 0 {
			return context.DeadlineExceeded
		}
		if ctx.Done() != nil && (timeout < 0 || timeout > int64(slice)) {
			timeout = int64(slice)
		}
		err := wait(C.int64_t(timeout))
		if failed, ok := err.(*Error); !ok || failed.Code != TimedOut {
			return err
		}
	}
}

// remaining is the context's time in ns, or -1 for ever.
func remaining(ctx context.Context) int64 {
	deadline, ok := ctx.Deadline()
	if !ok {
		return -1
	}
	if left := time.Until(deadline); left > 0 {
		return int64(left)
	}
	return 0
}

func truth(value bool) C.int32_t {
	if value {
		return 1
	}
	return 0
}

// address of bytes for the library; it takes any address for an empty message, but not NULL.
func address(data []byte) unsafe.Pointer {
	if len(data) == 0 {
		return unsafe.Pointer(&nothing[0])
	}
	return unsafe.Pointer(&data[0])
}

var nothing [1]byte
