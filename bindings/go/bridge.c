#include "bridge.h"

#include "_cgo_export.h"

static void Log(void* user, int32_t level, const char* text) { hgrosGoLog((uintptr_t)user, level, (char*)text); }

static __thread int32_t callbacks = 0;

int32_t GoInCallback(void) { return callbacks; }

static void Release(void* user) { hgrosGoRelease((uintptr_t)user); }

static void Handle(void* user, const hgros_message* request, hgros_reply* reply) {
  ++callbacks;
  hgrosGoHandle((uintptr_t)user, (hgros_message*)request, reply);
  --callbacks;
}

static void Replied(void* user, hgros_status status, const char* sentence, const hgros_message* reply) {
  hgrosGoReplied((uintptr_t)user, status, (char*)sentence, (hgros_message*)reply);
}

hgros_status GoSessionOpen(const char* yaml, const char* const* files, size_t count, const char* name, uintptr_t log,
                           hgros_session** session) {
  hgros_session_options options = {sizeof options};
  options.name = name;
  if (log != 0) {
    options.log = Log;
    options.log_user = (void*)log;
    options.log_release = Release;
  }
  if (files != NULL) return hgros_session_open_files(files, count, &options, session);
  return hgros_session_open(yaml, &options, session);
}

hgros_status GoServe(hgros_session* session, const char* name, const hgros_schema* request, const hgros_schema* reply,
                     uint64_t most_waiting, int32_t concurrent, uintptr_t handler, hgros_service** service) {
  hgros_serve_options options = {sizeof options};
  options.most_waiting = most_waiting;
  options.concurrent = concurrent;
  return hgros_serve(session, name, request, reply, &options, Handle, (void*)handler, Release, service);
}

hgros_status GoCallLater(hgros_session* session, const char* name, const hgros_schema* request, const void* data,
                         size_t size, const hgros_schema* reply, int64_t timeout_ns, uintptr_t user,
                         hgros_pending_call** call) {
  return hgros_call_later(session, name, request, data, size, reply, timeout_ns, Replied, (void*)user, Release, call);
}

static void Changed(void* user, const char* path, const char* yaml) {
  ++callbacks;
  hgrosGoChanged((uintptr_t)user, (char*)path, (char*)yaml);
  --callbacks;
}

hgros_status GoParamsWatch(hgros_params* params, const char* path, uintptr_t user, hgros_watch** watch) {
  return hgros_params_watch(params, path, Changed, (void*)user, Release, watch);
}

static void PeerEvent(void* user, int32_t event, const hgros_peer* peer, const char* channel, const char* reason) {
  ++callbacks;
  hgrosGoPeer((uintptr_t)user, event, (hgros_peer*)peer, (char*)channel, (char*)reason);
  --callbacks;
}

hgros_status GoWatchPeers(hgros_session* session, uintptr_t user, hgros_watch** watch) {
  return hgros_watch_peers(session, PeerEvent, (void*)user, Release, watch);
}

static void Tick(void* user, const hgros_tick* tick) {
  ++callbacks;
  hgrosGoTick((uintptr_t)user, (hgros_tick*)tick);
  --callbacks;
}

hgros_status GoTimerOpen(hgros_session* session, const char* name, int64_t period_ns, int64_t first_ns,
                         int32_t catch_up, uintptr_t user, hgros_timer** timer) {
  hgros_timer_options options = {sizeof options};
  options.first_ns = first_ns;
  options.catch_up = catch_up;
  return hgros_timer_open(session, name, period_ns, &options, Tick, (void*)user, Release, timer);
}
