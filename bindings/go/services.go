package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"context"
	"errors"
	"fmt"
	"runtime"
	"runtime/cgo"
	"strings"
	"unsafe"

	"google.golang.org/protobuf/proto"
)

// ServeOptions are read when a service is offered. nil is the default.
type ServeOptions struct {
	MostWaiting uint64 // Requests that may wait; further ones fail with Full. 0: 16384.
	Concurrent  bool   // Any number of requests may be handled at once.
}

// Service offers a service until it or its session is closed.
type Service struct {
	guard
	handle  *C.hgros_service
	session *Session
}

type rawHandler func(request *C.hgros_message) ([]byte, error)

// Serve offers a service. The handler runs on a thread of the session; its error becomes the caller's HandlerFailed
// with the same sentence, and so does a panic.
func Serve[Q, R proto.Message](s *Session, name string, handler func(Q) (R, error), options *ServeOptions) (*Service,
	error) {
	request, err := schemaFor[Q]()
	if err != nil {
		return nil, err
	}
	reply, err := schemaFor[R]()
	if err != nil {
		return nil, err
	}
	if handler == nil {
		return nil, &Error{InvalidArgument, "The handler of the service \"" + name + "\" is nil."}
	}
	return s.serve(name, request, reply, options, func(message *C.hgros_message) ([]byte, error) {
		into := newOf[Q]()
		if err := proto.Unmarshal(bytesOf(message), into); err != nil {
			return nil, err
		}
		answer, err := handler(into)
		if err != nil {
			return nil, err
		}
		return marshal(answer)
	})
}

func (s *Session) serve(name string, request, reply *Schema, options *ServeOptions, handler rawHandler) (*Service,
	error) {
	if err := uncut("The name of the service", name); err != nil {
		return nil, err
	}
	text := C.CString(name)
	defer C.free(unsafe.Pointer(text))
	var chosen ServeOptions
	if options != nil {
		chosen = *options
	}
	service := &Service{session: s}
	err := s.do("session", func() C.hgros_status {
		defer runtime.KeepAlive(request)
		defer runtime.KeepAlive(reply)
		return C.GoServe(s.handle, text, request.handle, reply.handle, C.uint64_t(chosen.MostWaiting),
			truth(chosen.Concurrent), C.uintptr_t(cgo.NewHandle(handler)), &service.handle)
	})
	if err != nil {
		return nil, err
	}
	service.free = func() { C.hgros_service_close(service.handle) }
	s.keep(service)
	return service, nil
}

// Close withdraws the service: requests that wait fail. Outside handlers it waits for the running ones.
func (s *Service) Close() {
	s.session.forget(s)
	s.close()
}

func bytesOf(message *C.hgros_message) []byte {
	var size C.size_t
	data := C.hgros_message_data(message, &size)
	return unsafe.Slice((*byte)(data), int(size))
}

type ending struct {
	reply []byte
	err   error
}

// Call calls a service and waits for its reply, until the context ends: then the call is cancelled.
func Call[Q, R proto.Message](ctx context.Context, s *Session, name string, request Q) (R, error) {
	var none R
	requestSchema, err := schemaFor[Q]()
	if err != nil {
		return none, err
	}
	replySchema, err := schemaFor[R]()
	if err != nil {
		return none, err
	}
	data, err := marshal(request)
	if err != nil {
		return none, err
	}
	bytes, err := s.call(ctx, name, requestSchema, data, replySchema)
	if err != nil {
		return none, err
	}
	into := newOf[R]()
	if err := proto.Unmarshal(bytes, into); err != nil {
		return none, &Error{NotWritable, "The reply of \"" + name + "\" cannot be read: " + err.Error()}
	}
	return into, nil
}

func (s *Session) call(ctx context.Context, name string, request *Schema, data []byte, reply *Schema) ([]byte, error) {
	if err := ctx.Err(); err != nil {
		return nil, err
	}
	if err := uncut("The name of the service", name); err != nil {
		return nil, err
	}
	text := C.CString(name)
	defer C.free(unsafe.Pointer(text))
	ended := make(chan ending, 1)
	var call *C.hgros_pending_call
	err := s.do("session", func() C.hgros_status {
		defer runtime.KeepAlive(request)
		defer runtime.KeepAlive(reply)
		return C.GoCallLater(s.handle, text, request.handle, address(data), C.size_t(len(data)), reply.handle,
			-1, C.uintptr_t(cgo.NewHandle(ended)), &call)
	})
	if err != nil {
		return nil, err
	}
	defer C.hgros_call_free(call)
	select {
	case end := <-ended:
		return end.reply, end.err
	case <-ctx.Done():
		C.hgros_call_cancel(call)
		return nil, ctx.Err()
	}
}

// The functions below run on threads of the library, which Go takes as its own meanwhile.

//export hgrosGoLog
func hgrosGoLog(user C.uintptr_t, level C.int32_t, text *C.char) {
	cgo.Handle(user).Value().(func(Level, string))(Level(level), C.GoString(text))
}

//export hgrosGoRelease
func hgrosGoRelease(user C.uintptr_t) { cgo.Handle(user).Delete() }

//export hgrosGoHandle
func hgrosGoHandle(user C.uintptr_t, request *C.hgros_message, reply *C.hgros_reply) {
	answer, err := answerOf(cgo.Handle(user).Value().(rawHandler), request)
	if err == nil {
		if C.hgros_reply_set(reply, address(answer), C.size_t(len(answer))) == C.HGROS_OK {
			return
		}
		err = errors.New(C.GoString(C.hgros_last_error()))
	}
	sentence := C.CString(strings.ReplaceAll(sentenceOf(err), "\x00", " "))
	defer C.free(unsafe.Pointer(sentence))
	C.hgros_reply_fail(reply, sentence)
}

func answerOf(handler rawHandler, request *C.hgros_message) (answer []byte, err error) {
	defer func() {
		if reason := recover(); reason != nil {
			err = fmt.Errorf("The handler panicked: %v", reason)
		}
	}()
	return handler(request)
}

// sentenceOf is what the error says, whose method may panic, as that of a nil pointer does.
func sentenceOf(err error) (sentence string) {
	defer func() {
		if reason := recover(); reason != nil {
			sentence = fmt.Sprintf("The handler's error panicked: %v", reason)
		}
	}()
	return err.Error()
}

//export hgrosGoReplied
func hgrosGoReplied(user C.uintptr_t, status C.int32_t, sentence *C.char, reply *C.hgros_message) {
	end := ending{}
	if status == C.HGROS_OK {
		end.reply = append([]byte{}, bytesOf(reply)...)
	} else {
		end.err = &Error{Code(status), C.GoString(sentence)}
	}
	cgo.Handle(user).Value().(chan ending) <- end
}
