#pragma once

#include "hgros/c/observe.h"
#include "hgros/c/session.h"

// Parameters: of this program, and of other sessions. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// A tree of parameters. A path is written like `slam.matcher.gains[2]`; values are YAML.
typedef struct hgros_params hgros_params;

/// Reads the parameters of this program from `count` YAML files, later ones over earlier ones. With a session, others
/// may read, watch and set them under the session's name; `session` may be NULL. The sections of sessions in the files
/// are left out. Errors: HGROS_CONFIG_ERROR with file, line and column; HGROS_ERROR.
hgros_status hgros_params_open(hgros_session* session, const char* const* files, size_t count, hgros_params** params);
/// The parameters that another session, or this one, offers under `name`. Each function on them asks that session and
/// waits at most `timeout_ns`, which must be above 0; closing the session waits for them. Do not call them in inline
/// callbacks or in callbacks of that session's parameters. Errors: HGROS_ERROR if the name cannot be one. That nobody
/// offers them is told by the functions.
hgros_status hgros_params_of(hgros_session* session, const char* name, int64_t timeout_ns, hgros_params** params);
/// Errors: HGROS_WOULD_DEADLOCK inside a callback of the session or of the parameters; then nothing is closed.
hgros_status hgros_params_close(hgros_params* params);

enum {
  HGROS_PARAM_BOOL = 0,
  HGROS_PARAM_INTEGER = 1,
  HGROS_PARAM_NUMBER = 2,
  HGROS_PARAM_TEXT = 3,
  HGROS_PARAM_NUMBERS = 4
};

typedef struct hgros_param_info {
  size_t size;
  int32_t read_only;  ///< Keeps the value from the start of the program.
  const char* description;
  const char* unit;
  int32_t has_least;  ///< `least` is a bound of a number, or of each number of a list. Bounds are included.
  int32_t has_most;   ///< The same for `most`.
  double least;
  double most;
  const char* const* choices;  ///< For a text.
  size_t choice_count;
} hgros_param_info;

/// Declares a parameter of this program: `kind` is HGROS_PARAM_..., `fallback` its value as YAML if it was never set.
/// From then on it always has that kind and keeps the bounds. `info` may be NULL.
/// Errors: HGROS_REFUSED if its current value does not, or if it was declared differently before; HGROS_ERROR for
/// parameters of another session.
hgros_status hgros_params_declare(hgros_params* params, const char* path, int32_t kind, const char* fallback,
                                  const hgros_param_info* info);

/// Read a value. Errors: HGROS_REFUSED with a sentence if it is not set, or not of the kind, or if the other session
/// does not answer. Texts are freed with hgros_text_free().
hgros_status hgros_params_get_bool(hgros_params* params, const char* path, int32_t* value);
hgros_status hgros_params_get_integer(hgros_params* params, const char* path, int64_t* value);
hgros_status hgros_params_get_number(hgros_params* params, const char* path, double* value);
hgros_status hgros_params_get_text(hgros_params* params, const char* path, char** value);
/// Any value, as YAML: a map as the lines of a file, anything else on one line. An empty path is the whole tree.
hgros_status hgros_params_get(hgros_params* params, const char* path, char** yaml);

/// Set a value. Errors: HGROS_REFUSED with a sentence if it breaks a declaration, or if a validator refuses it. A
/// parameter of another session must exist.
hgros_status hgros_params_set_bool(hgros_params* params, const char* path, int32_t value);
hgros_status hgros_params_set_integer(hgros_params* params, const char* path, int64_t value);
hgros_status hgros_params_set_number(hgros_params* params, const char* path, double value);
hgros_status hgros_params_set_text(hgros_params* params, const char* path, const char* value);
/// A value as YAML, such as "[1, 2]" or "{x: 1}".
hgros_status hgros_params_set(hgros_params* params, const char* path, const char* yaml);
/// Removes a value; a declared parameter returns to its fallback.
hgros_status hgros_params_remove(hgros_params* params, const char* path);
/// Writes what was set at run time into the files of this program. Errors: HGROS_ERROR if there is no file, one cannot
/// be written, or the parameters are those of another session.
hgros_status hgros_params_save(hgros_params* params);

/// A value has changed: its path, and its new value as YAML, or NULL if it was removed.
typedef void (*hgros_param_callback)(void* user, const char* path, const char* yaml);
/// Calls `callback` for each changed value at, below or above `path`, one change after the other; an empty path means
/// all. Runs on the thread that makes the change; for another session on a worker, first with all current values.
hgros_status hgros_params_watch(hgros_params* params, const char* path, hgros_param_callback callback, void* user,
                                hgros_release release, hgros_watch** watch);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
