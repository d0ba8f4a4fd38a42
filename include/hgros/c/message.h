#pragma once

#include "hgros/c/status.h"

// Schemas and messages. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// The type of messages: a name, an encoding and, for protobuf, a description. Never changes.
typedef struct hgros_schema hgros_schema;

enum {
  HGROS_ENCODING_NONE = 0,      ///< Only of received messages: unknown.
  HGROS_ENCODING_PROTOBUF = 1,  ///< The type's name is its full protobuf name.
  HGROS_ENCODING_CUSTOM = 2,    ///< A format that both sides agreed on by the type's name.
  HGROS_ENCODING_PLAIN = 3      ///< The bytes of a struct of numbers; only between equal layouts and byte orders.
};

/// A schema. `descriptor_set`: for protobuf, a serialized google.protobuf.FileDescriptorSet with the type's file and
/// all its imports, dependencies first, as `protoc --include_imports --descriptor_set_out=FILE` writes it; NULL: none.
/// `fingerprint` is computed from it; without it, 0 means that types are compared by name and encoding alone.
/// Errors: HGROS_ERROR if the description is not one of the type.
hgros_status hgros_schema_create(const char* type_name, int32_t encoding, uint64_t fingerprint,
                                 const void* descriptor_set, size_t descriptor_set_size, hgros_schema** schema);
/// The schema of a protobuf type that comes with the library, such as "foxglove.Log". Errors: HGROS_NOT_FOUND.
hgros_status hgros_schema_known(const char* type_name, hgros_schema** schema);
void hgros_schema_free(hgros_schema* schema);

/// Its parts; valid as long as the schema. NULL or 0 for NULL.
const char* hgros_schema_type_name(const hgros_schema* schema);
int32_t hgros_schema_encoding(const hgros_schema* schema);
uint64_t hgros_schema_fingerprint(const hgros_schema* schema);
/// `size` may be NULL. NULL and 0 if the schema has none.
const void* hgros_schema_descriptor_set(const hgros_schema* schema, size_t* size);

/// A received message, whose bytes nobody writes. It is a lease: the bytes may be in shared memory, which the sender
/// reuses when the last lease on it is freed. A process that keeps many large messages makes the sender use ordinary
/// memory, which costs a copy.
typedef struct hgros_message hgros_message;

typedef struct hgros_message_info {
  size_t size;
  int32_t remote;                ///< From another session.
  uint64_t publisher;            ///< The sender's session id.
  uint64_t incarnation;          ///< Grows with each start of the sender.
  uint64_t sequence;             ///< Counts the sender's messages on the channel.
  uint64_t key;                  ///< Names the message in all processes.
  int64_t publish_monotonic_ns;  ///< CLOCK_MONOTONIC of this host when published, or received from another host.
  int64_t publish_time_ns;       ///< The sender's wall clock; 0 for messages of the same session.
} hgros_message_info;

/// The message's bytes, valid as long as the message; 64-byte alignment is not promised. NULL and 0 for NULL.
/// `size` may be NULL.
const void* hgros_message_data(const hgros_message* message, size_t* size);
/// The sender's schema, valid as long as the message. NULL for NULL.
const hgros_schema* hgros_message_schema(const hgros_message* message);
/// Fills in `info`. All zero for requests and replies.
hgros_status hgros_message_get_info(const hgros_message* message, hgros_message_info* info);

/// A lease of its own on the same bytes, without a copy: keeps what a callback gets beyond its end.
hgros_status hgros_message_keep(const hgros_message* message, hgros_message** kept);
/// Ends a lease. Any thread; the lease may outlive its session.
void hgros_message_free(hgros_message* message);
/// The leases of this process that were returned and not yet freed.
uint64_t hgros_message_leases(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
