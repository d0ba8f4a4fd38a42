#pragma once

// The C interface of HyperGraph ROS (docs/c.md): C99, for C programs and as the base of other languages. Link
// libhgros_c.so (CMake: hgros::hgros_c; pkg-config: hgros_c).
//
// ABI
//   Symbols have the version HGROS_0. Functions and constants are never changed or removed; new ones are added.
//   Structs that may grow begin with `size_t size`: set it to sizeof of the struct before each call, and all other
//   fields of an options struct to 0 or to a value. 0 and NULL always mean the default. New fields come at the end;
//   fields beyond `size` are neither read nor written. A library that is older than the program refuses an option that
//   it does not know with HGROS_INVALID_ARGUMENT, and fills unknown fields with 0. The other structs never change.
//   Everything else is behind handles: pointers to types that only the library knows.
//
// Errors
//   A function that can fail returns a hgros_status. If it is not HGROS_OK, hgros_last_error() has a sentence about it
//   on the same thread, what it would have returned is NULL or 0, and nothing has happened. A NULL where a value is
//   needed gives HGROS_INVALID_ARGUMENT. No C++ exception leaves the library.
//
// Threads
//   Every function may be called by any thread and inside callbacks, unless it says otherwise. Callbacks run on threads
//   of the library, perhaps before the function that makes their handle has returned it. Close a handle when no other
//   thread uses it, and no longer use it then. hgros_session_end() wakes the threads that wait for a session.
//
// Ownership
//   Arguments are read during the call and belong to the caller. A handle that is returned belongs to the caller, who
//   closes or frees it once; NULL is ignored there. Handles may be closed in any order: those of a closed session do
//   nothing and return HGROS_CLOSED. What a callback gets is valid until it returns. `user` is passed to each call of
//   its callback. `release`, if given, is called once with `user` when no callback can come any more, also if the
//   function has failed, unless the function says otherwise. A callback that closes its own handle is released after
//   it, on its thread. So what holds inside a callback also holds inside its `release`, except where the program closes
//   the handle outside callbacks.
//
// Values
//   Texts are UTF-8 and end with a zero byte. Times and timeouts are nanoseconds; a timeout of 0 does not wait, a
//   negative one waits forever. Flags are int32_t: 0 is no.

#include "hgros/c/clock.h"       // IWYU pragma: export
#include "hgros/c/message.h"     // IWYU pragma: export
#include "hgros/c/observe.h"     // IWYU pragma: export
#include "hgros/c/params.h"      // IWYU pragma: export
#include "hgros/c/publish.h"     // IWYU pragma: export
#include "hgros/c/services.h"    // IWYU pragma: export
#include "hgros/c/session.h"     // IWYU pragma: export
#include "hgros/c/status.h"      // IWYU pragma: export
#include "hgros/c/subscribe.h"   // IWYU pragma: export
#include "hgros/c/transforms.h"  // IWYU pragma: export
