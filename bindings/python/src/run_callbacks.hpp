#pragma once

#include "bindings.hpp"
#include "inbox.hpp"
#include "ready_list.hpp"

namespace hgros::python {

// From what waits to callbacks without a line of Python in between: after a pause, each costs a microsecond.

/// Calls `callback(message, info)` with the waiting messages, at most `most`, while they have the schema that
/// Inbox::IsNew() was told last. `type` is a tuple: a function from the bytes to the message; the class of protobuf
/// whose FromString that is, or None; and a list, for the message that is made before it is needed. Returns 0: no more
/// wait, 1: more wait, 2: the next one has another schema. Errors: what reading or `callback` has raised;
/// Inbox::TakeUndecoded() tells which.
[[nodiscard]] int RunKnownOf(Inbox& inbox, const py::tuple& type, const py::object& callback, int most);

/// Waits as ReadyList::Wait() does, and calls the callbacks of keys that are in `known`, a dictionary of tuples (inbox,
/// type, callback, handler). Returns if there are other keys, after Wake(), when the time is over, after an
/// exception, and with `once` after a callback. Called with the GIL. Returns how many callbacks ran, the keys that are
/// left, and the handler and exception of the first of them, or None. Errors: throws what a signal's handler in Python
/// raised, such as KeyboardInterrupt.
[[nodiscard]] py::tuple RunCallbacks(ReadyList& ready, const py::dict& known, double timeout_s, bool once);

}  // namespace hgros::python
