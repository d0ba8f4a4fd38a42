#include <stdlib.h>

#include "addon.h"
#include "value.h"

// Fewer bytes are copied: that is faster than memory that the garbage collector has to hear of, and keeps no lease.
enum { kMostCopied = 16 * 1024 };

typedef struct {
  hgros_message* message;
  size_t size;
} Lease;

static void EndLease(napi_env napi, void* data, void* hint) {
  Lease* const lease = hint;
  int64_t known = 0;
  (void)data;
  napi_adjust_external_memory(napi, -(int64_t)lease->size, &known);
  hgros_message_free(lease->message);
  free(lease);
}

static napi_value CopyOf(napi_env napi, hgros_message* message, const void* data, size_t size) {
  napi_value buffer = NULL;
  napi_create_buffer_copy(napi, size, size > 0 ? data : "", NULL, &buffer);
  hgros_message_free(message);
  return buffer;
}

napi_value BufferOf(napi_env napi, hgros_message* message) {
  size_t size = 0;
  napi_value buffer = NULL;
  int64_t known = 0;
  const void* const data = hgros_message_data(message, &size);
  if (size <= kMostCopied) return CopyOf(napi, message, data, size);
  Lease* const lease = malloc(sizeof *lease);
  lease->message = message;
  lease->size = size;
  // An engine that keeps all memory in a cage takes no memory of others.
  if (napi_create_external_buffer(napi, size, (void*)data, EndLease, lease, &buffer) != napi_ok) {
    free(lease);
    return CopyOf(napi, message, data, size);
  }
  napi_adjust_external_memory(napi, (int64_t)size, &known);
  return buffer;
}

// detach(buffer): nobody can read it any more, and its memory is given back in the next turn of the loop.
static napi_value Detach(napi_env napi, napi_callback_info info) {
  napi_value buffer = NULL;
  napi_value memory = NULL;
  Arguments(napi, info, 1, &buffer);
  if (napi_get_typedarray_info(napi, buffer, NULL, NULL, NULL, &memory, NULL) == napi_ok) {
    napi_detach_arraybuffer(napi, memory);
  }
  return Undefined(napi);
}

static napi_value Leases(napi_env napi, napi_callback_info info) {
  (void)info;
  return Number(napi, (double)hgros_message_leases());
}

static void FreeSchema(napi_env napi, void* schema, void* nothing) {
  (void)napi;
  (void)nothing;
  hgros_schema_free(schema);
}

napi_value NewSchema(napi_env napi, hgros_schema* schema) {
  napi_value value = NULL;
  napi_create_external(napi, schema, FreeSchema, NULL, &value);
  return value;
}

const hgros_schema* SchemaOf(napi_env napi, napi_value value) {
  void* schema = NULL;
  napi_get_value_external(napi, value, &schema);
  return schema;
}

// createSchema(typeName, encoding, fingerprint, descriptorSet or undefined)
static napi_value CreateSchema(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  hgros_schema* schema = NULL;
  bool described = false;
  size_t size = 0;
  uint64_t fingerprint = 0;
  Arguments(napi, info, 4, arguments);
  char* const name = TextOf(napi, arguments[0]);
  napi_get_value_bigint_uint64(napi, arguments[2], &fingerprint, &(bool){false});
  napi_is_buffer(napi, arguments[3], &described);
  const void* const set = described ? BytesOf(napi, arguments[3], &size) : NULL;
  const hgros_status status =
      hgros_schema_create(name, (int32_t)NumberOf(napi, arguments[1]), fingerprint, set, size, &schema);
  free(name);
  return status == HGROS_OK ? NewSchema(napi, schema) : Checked(napi, status);
}

// knownSchema(typeName)
static napi_value KnownSchema(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  hgros_schema* schema = NULL;
  Arguments(napi, info, 1, &argument);
  char* const name = TextOf(napi, argument);
  const hgros_status status = hgros_schema_known(name, &schema);
  free(name);
  return status == HGROS_OK ? NewSchema(napi, schema) : Checked(napi, status);
}

// describeSchema(schema): its parts.
static napi_value DescribeSchema(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  napi_value object = NULL;
  napi_value set = Undefined(napi);
  size_t size = 0;
  Arguments(napi, info, 1, &argument);
  const hgros_schema* const schema = SchemaOf(napi, argument);
  const void* const bytes = hgros_schema_descriptor_set(schema, &size);
  if (bytes != NULL) napi_create_buffer_copy(napi, size, bytes, NULL, &set);
  napi_create_object(napi, &object);
  Set(napi, object, "typeName", Text(napi, hgros_schema_type_name(schema)));
  Set(napi, object, "encoding", Number(napi, hgros_schema_encoding(schema)));
  Set(napi, object, "fingerprint", BigId(napi, hgros_schema_fingerprint(schema)));
  Set(napi, object, "descriptorSet", set);
  return object;
}

static napi_value Version(napi_env napi, napi_callback_info info) {
  (void)info;
  return Text(napi, hgros_version());
}

static napi_value StatusName(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  return Text(napi, hgros_status_name((hgros_status)NumberOf(napi, argument)));
}

void DefineMessages(napi_env napi, napi_value exports) {
  Define(napi, exports, "detach", Detach);
  Define(napi, exports, "leases", Leases);
  Define(napi, exports, "createSchema", CreateSchema);
  Define(napi, exports, "knownSchema", KnownSchema);
  Define(napi, exports, "describeSchema", DescribeSchema);
  Define(napi, exports, "version", Version);
  Define(napi, exports, "statusName", StatusName);
}
