#include "value.h"

#include <stdlib.h>

#include "addon.h"

void Arguments(napi_env napi, napi_callback_info info, size_t count, napi_value* values) {
  napi_get_cb_info(napi, info, &count, values, NULL, NULL);
}

void Define(napi_env napi, napi_value exports, const char* name, napi_callback function) {
  napi_value made = NULL;
  napi_create_function(napi, name, NAPI_AUTO_LENGTH, function, NULL, &made);
  napi_set_named_property(napi, exports, name, made);
}

char* TextOf(napi_env napi, napi_value value) {
  size_t size = 0;
  if (napi_get_value_string_utf8(napi, value, NULL, 0, &size) != napi_ok) return NULL;
  char* const text = malloc(size + 1);
  napi_get_value_string_utf8(napi, value, text, size + 1, &size);
  return text;
}

char** TextsOf(napi_env napi, napi_value value, size_t* count) {
  uint32_t length = 0;
  napi_get_array_length(napi, value, &length);
  char** const texts = calloc((size_t)length + 1, sizeof *texts);
  *count = 0;
  for (uint32_t i = 0; i < length; ++i) {
    napi_value element = NULL;
    napi_get_element(napi, value, i, &element);
    texts[*count] = TextOf(napi, element);
    if (texts[*count] != NULL) ++*count;
  }
  return texts;
}

void FreeTexts(char** texts) {
  for (char** text = texts; *text != NULL; ++text) free(*text);
  free(texts);
}

const void* BytesOf(napi_env napi, napi_value value, size_t* size) {
  void* data = NULL;
  *size = 0;
  napi_get_buffer_info(napi, value, &data, size);
  return data != NULL ? data : "";
}

double NumberOf(napi_env napi, napi_value value) {
  double number = 0;
  napi_get_value_double(napi, value, &number);
  return number;
}

bool TruthOf(napi_env napi, napi_value value) {
  bool truth = false;
  napi_get_value_bool(napi, value, &truth);
  return truth;
}

int64_t IntegerOf(napi_env napi, napi_value value) {
  int64_t number = 0;
  bool lossless = false;
  napi_get_value_bigint_int64(napi, value, &number, &lossless);
  return number;
}

int64_t TimeoutOf(napi_env napi, napi_value value) {
  const double longest_ms = 9e12;  // Which int64_t has as nanoseconds.
  double milliseconds = -1;
  if (napi_get_value_double(napi, value, &milliseconds) != napi_ok || milliseconds > longest_ms) return -1;
  return (int64_t)(milliseconds * 1e6);
}

napi_value FieldOf(napi_env napi, napi_value object, const char* name) {
  napi_value value = NULL;
  napi_get_named_property(napi, object, name, &value);
  return value;
}

napi_value Undefined(napi_env napi) {
  napi_value value = NULL;
  napi_get_undefined(napi, &value);
  return value;
}

napi_value Text(napi_env napi, const char* text) {
  napi_value value = NULL;
  napi_create_string_utf8(napi, text != NULL ? text : "", NAPI_AUTO_LENGTH, &value);
  return value;
}

napi_value Number(napi_env napi, double number) {
  napi_value value = NULL;
  napi_create_double(napi, number, &value);
  return value;
}

napi_value Integer(napi_env napi, int64_t number) {
  const int64_t most = 9007199254740991;  // Number.MAX_SAFE_INTEGER
  return -most <= number && number <= most ? Number(napi, (double)number) : BigTime(napi, number);
}

napi_value Truth(napi_env napi, bool truth) {
  napi_value value = NULL;
  napi_get_boolean(napi, truth, &value);
  return value;
}

napi_value BigId(napi_env napi, uint64_t id) {
  napi_value value = NULL;
  napi_create_bigint_uint64(napi, id, &value);
  return value;
}

napi_value BigTime(napi_env napi, int64_t nanoseconds) {
  napi_value value = NULL;
  napi_create_bigint_int64(napi, nanoseconds, &value);
  return value;
}

void Set(napi_env napi, napi_value object, const char* name, napi_value value) {
  napi_set_named_property(napi, object, name, value);
}

napi_value ErrorOf(napi_env napi, hgros_status status, const char* sentence) {
  napi_value error_class = NULL;
  napi_value error = NULL;
  const napi_value arguments[] = {Number(napi, status), Text(napi, sentence)};
  napi_get_reference_value(napi, EnvOf(napi)->error_class, &error_class);
  napi_new_instance(napi, error_class, 2, arguments, &error);
  return error;
}

napi_value Throw(napi_env napi, hgros_status status, const char* sentence) {
  napi_throw(napi, ErrorOf(napi, status, sentence));
  return NULL;
}

napi_value Checked(napi_env napi, hgros_status status) {
  return status == HGROS_OK ? Undefined(napi) : Throw(napi, status, hgros_last_error());
}
