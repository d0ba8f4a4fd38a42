package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"runtime"
	"time"
	"unsafe"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protodesc"
	"google.golang.org/protobuf/reflect/protoreflect"
	"google.golang.org/protobuf/types/descriptorpb"
	"google.golang.org/protobuf/types/dynamicpb"
)

// Encoding says how the bytes of a type are written.
type Encoding int32

// The encodings of the library.
const (
	Unknown  Encoding = C.HGROS_ENCODING_NONE
	Protobuf Encoding = C.HGROS_ENCODING_PROTOBUF
	Custom   Encoding = C.HGROS_ENCODING_CUSTOM
	Plain    Encoding = C.HGROS_ENCODING_PLAIN
)

// Schema is the type of messages. It never changes.
type Schema struct {
	handle *C.hgros_schema
}

func newSchema(create func(handle **C.hgros_schema) C.hgros_status) (*Schema, error) {
	schema := &Schema{}
	if err := check(func() C.hgros_status { return create(&schema.handle) }); err != nil {
		return nil, err
	}
	runtime.SetFinalizer(schema, func(s *Schema) { C.hgros_schema_free(s.handle) })
	return schema, nil
}

// RawSchema names a type of your own whose bytes this package does not know. The fingerprint may be 0: then types are
// compared by name and encoding alone.
func RawSchema(typeName string, encoding Encoding, fingerprint uint64) (*Schema, error) {
	if err := uncut("The name of a type", typeName); err != nil {
		return nil, err
	}
	name := C.CString(typeName)
	defer C.free(unsafe.Pointer(name))
	return newSchema(func(handle **C.hgros_schema) C.hgros_status {
		return C.hgros_schema_create(name, C.int32_t(encoding), C.uint64_t(fingerprint), nil, 0, handle)
	})
}

// KnownSchema is a type that comes with the library, such as "foxglove.Log".
func KnownSchema(typeName string) (*Schema, error) {
	if err := uncut("The name of a type", typeName); err != nil {
		return nil, err
	}
	name := C.CString(typeName)
	defer C.free(unsafe.Pointer(name))
	return newSchema(func(handle **C.hgros_schema) C.hgros_status { return C.hgros_schema_known(name, handle) })
}

// SchemaOf is the type of protobuf messages with this descriptor: its name, and its file with all imports.
func SchemaOf(descriptor protoreflect.MessageDescriptor) (*Schema, error) {
	set := &descriptorpb.FileDescriptorSet{}
	addFile(set, map[string]bool{}, descriptor.ParentFile())
	data, err := proto.MarshalOptions{Deterministic: true}.Marshal(set)
	if err != nil {
		return nil, &Error{NotWritable, "The description of " + string(descriptor.FullName()) + ": " + err.Error()}
	}
	name := C.CString(string(descriptor.FullName()))
	defer C.free(unsafe.Pointer(name))
	return newSchema(func(handle **C.hgros_schema) C.hgros_status {
		return C.hgros_schema_create(name, C.HGROS_ENCODING_PROTOBUF, 0, address(data), C.size_t(len(data)), handle)
	})
}

// addFile adds a file after its imports.
func addFile(set *descriptorpb.FileDescriptorSet, added map[string]bool, file protoreflect.FileDescriptor) {
	if added[file.Path()] {
		return
	}
	added[file.Path()] = true
	imports := file.Imports()
	for i := 0; i < imports.Len(); i++ {
		addFile(set, added, imports.Get(i).FileDescriptor)
	}
	set.File = append(set.File, protodesc.ToFileDescriptorProto(file))
}

// TypeName is the full name of the type.
func (s *Schema) TypeName() string {
	defer runtime.KeepAlive(s)
	return C.GoString(C.hgros_schema_type_name(s.handle))
}

// Encoding says how its bytes are written.
func (s *Schema) Encoding() Encoding {
	defer runtime.KeepAlive(s)
	return Encoding(C.hgros_schema_encoding(s.handle))
}

// Fingerprint is equal for equal types; 0: unknown.
func (s *Schema) Fingerprint() uint64 {
	defer runtime.KeepAlive(s)
	return uint64(C.hgros_schema_fingerprint(s.handle))
}

// Descriptor is the type's protobuf description, as it came with the schema.
func (s *Schema) Descriptor() (protoreflect.MessageDescriptor, error) {
	defer runtime.KeepAlive(s)
	var size C.size_t
	data := C.hgros_schema_descriptor_set(s.handle, &size)
	if data == nil {
		return nil, &Error{NotFound, "The type \"" + s.TypeName() + "\" has no protobuf description."}
	}
	set := &descriptorpb.FileDescriptorSet{}
	if err := proto.Unmarshal(unsafe.Slice((*byte)(data), int(size)), set); err != nil {
		return nil, &Error{NotWritable, "The description of " + s.TypeName() + ": " + err.Error()}
	}
	files, err := protodesc.NewFiles(set)
	if err != nil {
		return nil, &Error{NotWritable, "The description of " + s.TypeName() + ": " + err.Error()}
	}
	found, err := files.FindDescriptorByName(protoreflect.FullName(s.TypeName()))
	message, ok := found.(protoreflect.MessageDescriptor)
	if err != nil || !ok {
		return nil, &Error{NotFound, "The description of " + s.TypeName() + " has no message of this name."}
	}
	return message, nil
}

// New is an empty message of the type, without generated code.
func (s *Schema) New() (*dynamicpb.Message, error) {
	descriptor, err := s.Descriptor()
	if err != nil {
		return nil, err
	}
	return dynamicpb.NewMessage(descriptor), nil
}

// Info says where a message comes from.
type Info struct {
	Remote      bool   // From another session.
	Publisher   uint64 // The sender's session id.
	Sequence    uint64 // Counts the sender's messages on the channel.
	Key         uint64 // Names the message in all processes.
	PublishTime time.Time
}

// Message is a received message. Its bytes are a lease on the sender's memory: Close it soon. One that is forgotten is
// closed by the garbage collector.
type Message struct {
	guard
	handle *C.hgros_message
}

func newMessage(handle *C.hgros_message) *Message {
	message := &Message{handle: handle}
	message.free = func() { C.hgros_message_free(handle) }
	runtime.SetFinalizer(message, (*Message).Close)
	return message
}

// Close ends the lease. The bytes of Data may not be read after it.
func (m *Message) Close() {
	runtime.SetFinalizer(m, nil)
	m.close()
}

// Data is the message's bytes, without a copy. Nobody may write them, and nobody may read them once the message is
// closed or forgotten: keep the message, and close it when the bytes are read. nil once it is closed.
func (m *Message) Data() []byte {
	if m.enter("message") != nil {
		return nil
	}
	defer m.leave()
	var size C.size_t
	data := C.hgros_message_data(m.handle, &size)
	return unsafe.Slice((*byte)(data), int(size))
}

// Schema is a copy of the type that came with the channel.
func (m *Message) Schema() (*Schema, error) {
	if err := m.enter("message"); err != nil {
		return nil, err
	}
	defer m.leave()
	came := C.hgros_message_schema(m.handle)
	var size C.size_t
	set := C.hgros_schema_descriptor_set(came, &size)
	return newSchema(func(handle **C.hgros_schema) C.hgros_status {
		return C.hgros_schema_create(C.hgros_schema_type_name(came), C.hgros_schema_encoding(came),
			C.hgros_schema_fingerprint(came), set, size, handle)
	})
}

// Read decodes the message into one of its type.
func (m *Message) Read(into proto.Message) error {
	if err := m.enter("message"); err != nil {
		return err
	}
	defer m.leave()
	var size C.size_t
	data := C.hgros_message_data(m.handle, &size)
	name := string(into.ProtoReflect().Descriptor().FullName())
	if came := C.GoString(C.hgros_schema_type_name(C.hgros_message_schema(m.handle))); came != name {
		return &Error{TypeMismatch, "The message is a \"" + came + "\", but is read as \"" + name + "\"."}
	}
	if err := proto.Unmarshal(unsafe.Slice((*byte)(data), int(size)), into); err != nil {
		return &Error{NotWritable, "The message cannot be read as " + name + ": " + err.Error()}
	}
	return nil
}

// Decode reads the message with the type that came with the channel, without generated code.
func (m *Message) Decode() (*dynamicpb.Message, error) {
	schema, err := m.Schema()
	if err != nil {
		return nil, err
	}
	message, err := schema.New()
	if err != nil {
		return nil, err
	}
	if err := m.Read(message); err != nil {
		return nil, err
	}
	return message, nil
}

// Info says where the message comes from.
func (m *Message) Info() (Info, error) {
	info := C.hgros_message_info{size: C.sizeof_hgros_message_info}
	if err := m.do("message", func() C.hgros_status { return C.hgros_message_get_info(m.handle, &info) }); err != nil {
		return Info{}, err
	}
	return Info{Remote: info.remote != 0, Publisher: uint64(info.publisher), Sequence: uint64(info.sequence),
		Key: uint64(info.key), PublishTime: time.Unix(0, int64(info.publish_time_ns))}, nil
}

// Leases is the number of messages of this process that are not yet closed.
func Leases() uint64 { return uint64(C.hgros_message_leases()) }
