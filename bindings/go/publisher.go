package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"context"
	"runtime"
	"unsafe"

	"google.golang.org/protobuf/proto"
)

// PublishOptions are read when a channel is announced. nil is the default.
type PublishOptions struct {
	Latched uint64 // Number of recent messages kept for late subscribers.
}

// RawPublisher publishes bytes of one type on one channel.
type RawPublisher struct {
	guard
	handle  *C.hgros_publisher
	session *Session // Not forgotten while its publisher is used.
}

// AdvertiseRaw announces a channel of a type.
func (s *Session) AdvertiseRaw(channel string, schema *Schema, options *PublishOptions) (*RawPublisher, error) {
	if schema == nil {
		return nil, &Error{InvalidArgument, "The schema of channel \"" + channel + "\" is nil, but must be one."}
	}
	if err := uncut("The name of the channel", channel); err != nil {
		return nil, err
	}
	name := C.CString(channel)
	defer C.free(unsafe.Pointer(name))
	chosen := C.hgros_publish_options{size: C.sizeof_hgros_publish_options}
	if options != nil {
		chosen.latched = C.uint64_t(options.Latched)
	}
	publisher := &RawPublisher{session: s}
	if err := s.do("session", func() C.hgros_status {
		defer runtime.KeepAlive(schema)
		return C.hgros_publisher_open(s.handle, name, schema.handle, &chosen, &publisher.handle)
	}); err != nil {
		return nil, err
	}
	handle := publisher.handle
	publisher.free = func() { C.hgros_publisher_close(handle) }
	runtime.SetFinalizer(publisher, (*RawPublisher).Close)
	return publisher, nil
}

// Publish publishes a copy of the bytes. It never waits: Full says that a lossless subscriber has no room.
func (p *RawPublisher) Publish(data []byte) error {
	return p.do("publisher", func() C.hgros_status {
		return C.hgros_publish(p.handle, address(data), C.size_t(len(data)))
	})
}

// PublishWait publishes a copy of the bytes, and waits while a lossless subscriber has no room.
func (p *RawPublisher) PublishWait(ctx context.Context, data []byte) error {
	return poll(ctx, func(timeout C.int64_t) error {
		return p.do("publisher", func() C.hgros_status {
			return C.hgros_publish_wait(p.handle, address(data), C.size_t(len(data)), timeout)
		})
	})
}

// Close ends the publisher.
func (p *RawPublisher) Close() {
	runtime.SetFinalizer(p, nil)
	p.close()
}

// Publisher publishes protobuf messages of one type on one channel.
type Publisher[T proto.Message] struct{ raw *RawPublisher }

// Advertise announces a channel of a protobuf type, whose description goes with it.
func Advertise[T proto.Message](s *Session, channel string, options *PublishOptions) (*Publisher[T], error) {
	schema, err := schemaFor[T]()
	if err != nil {
		return nil, err
	}
	raw, err := s.AdvertiseRaw(channel, schema, options)
	if err != nil {
		return nil, err
	}
	return &Publisher[T]{raw}, nil
}

// Publish publishes a message. It never waits: Full says that a lossless subscriber has no room.
func (p *Publisher[T]) Publish(message T) error {
	data, err := marshal(message)
	if err != nil {
		return err
	}
	return p.raw.Publish(data)
}

// PublishWait publishes a message, and waits while a lossless subscriber has no room.
func (p *Publisher[T]) PublishWait(ctx context.Context, message T) error {
	data, err := marshal(message)
	if err != nil {
		return err
	}
	return p.raw.PublishWait(ctx, data)
}

// Close ends the publisher.
func (p *Publisher[T]) Close() { p.raw.Close() }

func marshal(message proto.Message) ([]byte, error) {
	data, err := proto.Marshal(message)
	if err != nil {
		return nil, &Error{NotWritable, "The message cannot be written: " + err.Error()}
	}
	return data, nil
}

// schemaFor reads the descriptor of a generated type, which needs no message.
func schemaFor[T proto.Message]() (*Schema, error) {
	var none T
	if any(none) == nil {
		return nil, &Error{InvalidArgument, "The type of the messages is an interface, but must be a generated one."}
	}
	return SchemaOf(none.ProtoReflect().Descriptor())
}

// newOf is an empty message of a generated type.
func newOf[T proto.Message]() T {
	var none T
	return none.ProtoReflect().New().Interface().(T)
}
