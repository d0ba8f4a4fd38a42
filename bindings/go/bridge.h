#pragma once

#include <stdint.h>

#include "hgros/hgros.h"

// What cgo cannot write: callbacks of C that call Go, and options that hold them. `user` is a runtime/cgo.Handle, which
// the library carries as a pointer that nobody reads.

hgros_status GoSessionOpen(const char* yaml, const char* const* files, size_t count, const char* name, uintptr_t log,
                           hgros_session** session);
hgros_status GoServe(hgros_session* session, const char* name, const hgros_schema* request, const hgros_schema* reply,
                     uint64_t most_waiting, int32_t concurrent, uintptr_t handler, hgros_service** service);
hgros_status GoCallLater(hgros_session* session, const char* name, const hgros_schema* request, const void* data,
                         size_t size, const hgros_schema* reply, int64_t timeout_ns, uintptr_t user,
                         hgros_pending_call** call);
hgros_status GoParamsWatch(hgros_params* params, const char* path, uintptr_t user, hgros_watch** watch);
hgros_status GoTimerOpen(hgros_session* session, const char* name, int64_t period_ns, int64_t first_ns,
                         int32_t catch_up, uintptr_t user, hgros_timer** timer);
// This thread runs a callback that the program gave to a session.
int32_t GoInCallback(void);
hgros_status GoWatchPeers(hgros_session* session, uintptr_t user, hgros_watch** watch);
