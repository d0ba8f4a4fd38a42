#pragma once

#include <node_api.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hgros/hgros.h"

// Values of JavaScript.

/// Reads the arguments of a call; those that are missing are undefined.
void Arguments(napi_env napi, napi_callback_info info, size_t count, napi_value* values);
void Define(napi_env napi, napi_value exports, const char* name, napi_callback function);

/// A copy, or NULL if the value is no text. The caller frees it.
char* TextOf(napi_env napi, napi_value value);
/// A list of texts that ends with NULL.
char** TextsOf(napi_env napi, napi_value value, size_t* count);
void FreeTexts(char** texts);
/// The bytes of a Buffer, valid during the call; an empty one has an address, too.
const void* BytesOf(napi_env napi, napi_value value, size_t* size);
double NumberOf(napi_env napi, napi_value value);
bool TruthOf(napi_env napi, napi_value value);
/// A bigint.
int64_t IntegerOf(napi_env napi, napi_value value);
/// Milliseconds as nanoseconds; undefined is -1, for ever.
int64_t TimeoutOf(napi_env napi, napi_value value);
napi_value FieldOf(napi_env napi, napi_value object, const char* name);

napi_value Undefined(napi_env napi);
napi_value Text(napi_env napi, const char* text);
napi_value Number(napi_env napi, double number);
/// A number, or a bigint if a number does not have all its digits.
napi_value Integer(napi_env napi, int64_t number);
napi_value Truth(napi_env napi, bool truth);
napi_value BigId(napi_env napi, uint64_t id);
napi_value BigTime(napi_env napi, int64_t nanoseconds);
void Set(napi_env napi, napi_value object, const char* name, napi_value value);

/// An HgrosError.
napi_value ErrorOf(napi_env napi, hgros_status status, const char* sentence);
/// Throws it, and is NULL.
napi_value Throw(napi_env napi, hgros_status status, const char* sentence);
/// Undefined, or throws the last error of this thread.
napi_value Checked(napi_env napi, hgros_status status);
