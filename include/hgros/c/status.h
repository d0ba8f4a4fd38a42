#pragma once

#include <stddef.h>
#include <stdint.h>

// Status codes and the last error. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// One of the values below.
typedef int32_t hgros_status;

enum {
  HGROS_OK = 0,
  HGROS_INVALID_ARGUMENT = 1,  ///< NULL where a value is needed, or a number outside its range.
  HGROS_ERROR = 2,             ///< Wiring failed for another reason: a name, an endpoint, a limit of the system.
  HGROS_TYPE_MISMATCH = 3,     ///< Both sides use different types. The sentence names both.
  HGROS_CONFIG_ERROR = 4,      ///< A configuration is wrong. The sentence has file, line and column.
  HGROS_CLOSED = 5,            ///< The session, or the handle's object, has ended.
  HGROS_FULL = 6,              ///< A lossless subscriber has no room, or too many calls wait. Nobody got the message.
  HGROS_TIMED_OUT = 7,         ///< The timeout came first; for a queue: no message waits.
  HGROS_WOULD_DEADLOCK = 8,    ///< Waiting was refused: this thread runs a callback that the wait could depend on.
  HGROS_TOO_LARGE = 9,         ///< Larger than 1 GiB, and another session subscribes.
  HGROS_NO_MEMORY = 10,
  HGROS_NOT_FOUND = 11,       ///< There is nothing of this name or number.
  HGROS_REFUSED = 12,         ///< A parameter or a transform was refused. The sentence says why.
  HGROS_NO_SERVER = 20,       ///< No session serves that name.
  HGROS_HANDLER_FAILED = 21,  ///< The handler failed. The sentence is its own.
  HGROS_SERVER_GONE = 22,     ///< The server died or left during the call.
  HGROS_CANCELLED = 23,       ///< The caller has cancelled the call.
  HGROS_NOT_WRITABLE = 24,    ///< The request or the reply could not be written or read as its type.
  HGROS_UNKNOWN_FRAME = 30,   ///< No transform has a frame of this name.
  HGROS_NOT_CONNECTED = 31,   ///< Both frames are known, but in separate trees.
  HGROS_TOO_OLD = 32,         ///< Before the oldest transform that is remembered.
  HGROS_TOO_NEW = 33          ///< After the newest transform.
};

/// "ok", "full" ...; "unknown" for another number. The text is constant.
const char* hgros_status_name(hgros_status status);

/// What went wrong in the last call of this thread that failed, where, and how to mend it. Empty if none has failed.
/// The text belongs to the library and is valid until this thread calls a function that fails. A call that succeeds
/// leaves it as it is. Languages that move between threads call it on the thread that made the failed call.
const char* hgros_last_error(void);

/// The version of the library, such as "0.1.0".
const char* hgros_version(void);

/// Called with `user` when the library does not need it any more.
typedef void (*hgros_release)(void* user);

/// A text that a function returned for the caller to free.
void hgros_text_free(char* text);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
