package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"context"
	"errors"
	"os"
	"runtime"
	"syscall"
	"time"
	"unsafe"

	"google.golang.org/protobuf/proto"
)

// SubscribeOptions are read when a subscription begins. nil is the default: the 16 newest messages.
type SubscribeOptions struct {
	Name         string  // For logs, tables and configuration; empty: channel and number.
	Schema       *Schema // The expected type; nil: any. Subscribe sets it.
	KeepLast     uint64  // Newest messages that may wait, older ones are dropped and counted; 0: 16.
	KeepAll      uint64  // Not 0: lossless, with room for this many. Publishers get Full meanwhile.
	KeepAllBytes uint64  // For KeepAll: also at most about this many bytes; 0: no limit.
}

// Stats counts since a subscription began.
type Stats struct {
	Received   uint64 // Messages that reached it, including those dropped later.
	Dropped    uint64 // Removed from a full keep-last queue.
	Taken      uint64
	Queued     uint64 // Waiting now.
	Mismatched uint64 // Not delivered: of another type.
}

// RawSubscription is a queue of received messages.
type RawSubscription struct {
	guard
	handle  *C.hgros_subscription
	session *Session
	ready   *os.File      // A copy of the queue's descriptor, on which Go's poller waits without a thread.
	turn    chan struct{} // Held by the one that waits for the descriptor.
}

// SubscribeRaw receives a channel of any type, or of that in the options, as bytes.
func (s *Session) SubscribeRaw(channel string, options *SubscribeOptions) (*RawSubscription, error) {
	if err := uncut("The name of the channel", channel); err != nil {
		return nil, err
	}
	name := C.CString(channel)
	defer C.free(unsafe.Pointer(name))
	// In memory of C, because it points to other memory.
	chosen := (*C.hgros_subscribe_options)(C.calloc(1, C.sizeof_hgros_subscribe_options))
	defer C.free(unsafe.Pointer(chosen))
	chosen.size = C.sizeof_hgros_subscribe_options
	if options != nil {
		if err := uncut("The name of the subscription", options.Name); err != nil {
			return nil, err
		}
		if options.Name != "" {
			chosen.name = C.CString(options.Name)
			defer C.free(unsafe.Pointer(chosen.name))
		}
		if options.Schema != nil {
			chosen.schema = options.Schema.handle
			defer runtime.KeepAlive(options.Schema)
		}
		chosen.keep_last = C.uint64_t(options.KeepLast)
		chosen.keep_all = C.uint64_t(options.KeepAll)
		chosen.keep_all_bytes = C.uint64_t(options.KeepAllBytes)
	}
	queue := &RawSubscription{session: s, turn: make(chan struct{}, 1)}
	if err := s.do("session", func() C.hgros_status {
		return C.hgros_subscribe_queue(s.handle, name, chosen, &queue.handle)
	}); err != nil {
		return nil, err
	}
	descriptor, err := syscall.Dup(int(C.hgros_queue_descriptor(queue.handle)))
	if err != nil {
		C.hgros_subscription_close(queue.handle)
		return nil, &Error{Failed, "The descriptor of channel \"" + channel + "\" cannot be copied: " + err.Error()}
	}
	syscall.CloseOnExec(descriptor)
	queue.ready = os.NewFile(uintptr(descriptor), "hgros:"+channel)
	handle, ready := queue.handle, queue.ready
	queue.free = func() {
		_ = ready.Close()
		C.hgros_subscription_close(handle)
	}
	runtime.SetFinalizer(queue, (*RawSubscription).Close)
	return queue, nil
}

// Close ends the subscription and wakes those that wait in Take.
func (q *RawSubscription) Close() {
	runtime.SetFinalizer(q, nil)
	if q.enter("subscription") != nil {
		return
	}
	C.hgros_subscription_end(q.handle)
	q.close()
	q.leave()
}

// TryTake takes the oldest message; TimedOut if none waits.
func (q *RawSubscription) TryTake() (*Message, error) {
	var handle *C.hgros_message
	if err := q.do("subscription", func() C.hgros_status {
		return C.hgros_queue_take(q.handle, 0, &handle)
	}); err != nil {
		return nil, err
	}
	return newMessage(handle), nil
}

// Take waits for the oldest message, which the caller closes. Each message goes to one goroutine. The error is Closed
// once the subscription or its session has ended, or that of the context.
func (q *RawSubscription) Take(ctx context.Context) (*Message, error) {
	if err := ctx.Err(); err != nil {
		return nil, err
	}
	if message, err := q.TryTake(); !errors.Is(err, TimedOut) {
		return message, err
	}
	if err := q.enter("subscription"); err != nil {
		return nil, err
	}
	defer q.leave()
	select {
	case q.turn <- struct{}{}:
		defer func() { <-q.turn }()
	case <-ctx.Done():
		return nil, ctx.Err()
	}
	defer q.interruptWith(ctx)()
	poller, err := q.ready.SyscallConn()
	if err != nil {
		return nil, &Error{Closed, "The subscription is closed."}
	}
	var message *Message
	var failure error
	if err := poller.Read(func(uintptr) bool {
		message, failure = q.TryTake()
		return !errors.Is(failure, TimedOut)
	}); err != nil {
		if ctx.Err() != nil {
			return nil, ctx.Err()
		}
		return nil, &Error{Failed, "Waiting for a message failed: " + err.Error()}
	}
	return message, failure
}

// interruptWith makes the wait for the descriptor end with the context; the result undoes that.
func (q *RawSubscription) interruptWith(ctx context.Context) func() {
	if ctx.Done() == nil {
		return func() {}
	}
	taken, over := make(chan struct{}), make(chan struct{})
	go func() {
		defer close(over)
		select {
		case <-ctx.Done():
			_ = q.ready.SetReadDeadline(time.Unix(1, 0))
		case <-taken:
		}
	}()
	return func() {
		close(taken)
		<-over
		_ = q.ready.SetReadDeadline(time.Time{})
	}
}

// Stats counts since the subscription began.
func (q *RawSubscription) Stats() (Stats, error) {
	stats := C.hgros_subscription_stats{size: C.sizeof_hgros_subscription_stats}
	if err := q.do("subscription", func() C.hgros_status {
		return C.hgros_subscription_get_stats(q.handle, &stats)
	}); err != nil {
		return Stats{}, err
	}
	return Stats{uint64(stats.received), uint64(stats.dropped), uint64(stats.run), uint64(stats.queued),
		uint64(stats.mismatched)}, nil
}

// Subscription is a queue of received protobuf messages of one type.
type Subscription[T proto.Message] struct{ *RawSubscription }

// Subscribe receives a channel of a protobuf type. Messages of another type are counted, not delivered.
func Subscribe[T proto.Message](s *Session, channel string, options *SubscribeOptions) (*Subscription[T], error) {
	schema, err := schemaFor[T]()
	if err != nil {
		return nil, err
	}
	chosen := SubscribeOptions{}
	if options != nil {
		chosen = *options
	}
	chosen.Schema = schema
	raw, err := s.SubscribeRaw(channel, &chosen)
	if err != nil {
		return nil, err
	}
	return &Subscription[T]{raw}, nil
}

// Next waits for the oldest message and decodes it. Take gives its bytes and its Info instead.
func (q *Subscription[T]) Next(ctx context.Context) (T, error) {
	var none T
	message, err := q.Take(ctx)
	if err != nil {
		return none, err
	}
	defer message.Close()
	into := newOf[T]()
	if err := message.Read(into); err != nil {
		return none, err
	}
	return into, nil
}
