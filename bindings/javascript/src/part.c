#include <stdlib.h>

#include "addon.h"
#include "value.h"

void RetainPart(Part* part) {
  pthread_mutex_lock(&part->env->mutex);
  ++part->refs;
  pthread_mutex_unlock(&part->env->mutex);
}

void ReleasePart(Part* part) {
  Env* const env = part->env;
  pthread_mutex_lock(&env->mutex);
  const bool last = --part->refs == 0;
  pthread_mutex_unlock(&env->mutex);
  if (!last) return;
  free(part);
  ReleaseEnv(env);
}

// Each handle is closed once: by the one that takes it.
static void CloseHandle(Part* part) {
  pthread_mutex_lock(&part->env->mutex);
  void* const handle = part->jobs > 0 ? NULL : part->handle;
  if (handle != NULL) part->handle = NULL;
  pthread_mutex_unlock(&part->env->mutex);
  if (handle != NULL) part->close(handle);
}

// JavaScript has forgotten the part, perhaps because it ends. An open part stays: it is closed with its session.
static void Forgotten(napi_env napi, void* part, void* nothing) {
  (void)napi;
  (void)nothing;
  ReleasePart(part);
}

napi_value NewPart(Env* env, Part* session, void (*close)(void*), napi_value callback, Part** part) {
  napi_value value = NULL;
  *part = calloc(1, sizeof **part);
  pthread_mutex_lock(&env->mutex);
  ++env->refs;
  pthread_mutex_unlock(&env->mutex);
  (*part)->env = env;
  (*part)->session = session;
  (*part)->close = close;
  (*part)->refs = 2;  // JavaScript's, and that of an open part.
  if (callback != NULL) napi_create_reference(env->napi, callback, 1, &(*part)->callback);
  napi_create_external(env->napi, *part, Forgotten, NULL, &value);
  return value;
}

static void ForgetCallback(Part* part) {
  if (part->callback != NULL) napi_delete_reference(part->env->napi, part->callback);
  part->callback = NULL;
}

napi_value Opened(Part* part, void* handle, hgros_status status, napi_value value) {
  Env* const env = part->env;
  if (status != HGROS_OK) {
    ForgetCallback(part);
    part->closed = true;
    ReleasePart(part);
    return Checked(env->napi, status);
  }
  part->handle = handle;
  pthread_mutex_lock(&env->mutex);
  part->next = env->parts;
  env->parts = part;
  pthread_mutex_unlock(&env->mutex);
  if (part->keeps_awake) KeepAwake(env, 1);
  return value;
}

Part* PartOf(napi_env napi, napi_value value) {
  void* part = NULL;
  napi_get_value_external(napi, value, &part);
  return part;
}

Part* OpenPartOf(napi_env napi, napi_value value, const char* what) {
  Part* const part = PartOf(napi, value);
  if (!part->closed) return part;
  Throw(napi, HGROS_CLOSED, what);
  return NULL;
}

static void FreePoll(uv_handle_t* poll) {
  Part* const part = poll->data;
  free(poll);
  UvHandleClosed(part->env);
  ReleasePart(part);
}

bool AddPoll(Part* part, uv_loop_t* loop, int descriptor) {
  uv_poll_t* const poll = malloc(sizeof *poll);
  if (uv_poll_init(loop, poll, descriptor) != 0) {
    free(poll);
    return false;
  }
  poll->data = part;
  part->poll = poll;
  ++part->env->uv_handles;
  RetainPart(part);
  return true;
}

// Takes the part out of the list of the open ones, and lets go what JavaScript's thread has for it.
static bool Withdraw(Part* part) {
  Env* const env = part->env;
  pthread_mutex_lock(&env->mutex);
  const bool was_open = !part->closed;
  if (was_open) {
    part->closed = true;
    Part** place = &env->parts;
    while (*place != part) place = &(*place)->next;
    *place = part->next;
  }
  pthread_mutex_unlock(&env->mutex);
  if (!was_open) return false;
  if (part->keeps_awake) KeepAwake(env, -1);
  if (part->poll != NULL) uv_close((uv_handle_t*)part->poll, FreePoll);
  hgros_schema_free(part->schema);
  ForgetCallback(part);
  return true;
}

void ClosePart(Part* part) {
  if (!Withdraw(part)) return;
  CloseHandle(part);  // Or the last job does.
  ReleasePart(part);
}

void UsePart(Part* part) {
  pthread_mutex_lock(&part->env->mutex);
  ++part->refs;
  ++part->jobs;
  if (part->session != NULL) ++part->session->jobs;
  pthread_mutex_unlock(&part->env->mutex);
}

void LeavePart(Part* part) {
  Env* const env = part->env;
  pthread_mutex_lock(&env->mutex);
  const bool ends = --part->jobs == 0 && part->closed;  // One thread only sees that.
  pthread_mutex_unlock(&env->mutex);
  if (ends) CloseHandle(part);
  pthread_mutex_lock(&env->mutex);
  if (part->session != NULL) --part->session->jobs;
  pthread_cond_broadcast(&env->changed);
  pthread_mutex_unlock(&env->mutex);
  ReleasePart(part);
}

typedef struct {
  Job job;
  Part* parts;  // Those of the session, which are closed with it.
} CloseJob;

static void WorkClose(Job* job) {
  CloseJob* const close = (CloseJob*)job;
  Env* const env = job->env;
  pthread_mutex_lock(&env->mutex);
  while (job->part->jobs > 1) pthread_cond_wait(&env->changed, &env->mutex);  // All but this one.
  pthread_mutex_unlock(&env->mutex);
  while (close->parts != NULL) {
    Part* const part = close->parts;
    close->parts = part->next;
    CloseHandle(part);
    ReleasePart(part);
  }
  ReleasePart(job->part);  // As an open one. Its handle is closed when this job leaves it.
}

static void FreeClose(Job* job) { free(job); }

napi_value ClosePartLater(Part* part) {
  Env* const env = part->env;
  if (part->closed) return Undefined(env->napi);
  CloseJob* const close = calloc(1, sizeof *close);
  close->job.work = WorkClose;
  close->job.free = FreeClose;
  if (part->session == NULL) {
    pthread_mutex_lock(&env->mutex);
    FailRequests(env, part, "The session of the service is closed.");
    pthread_mutex_unlock(&env->mutex);
    hgros_session_end(part->handle);
    for (Part* child = env->parts; child != NULL;) {
      Part* const next = child->next;
      if (child->session == part) {
        Withdraw(child);
        child->next = close->parts;
        close->parts = child;
      }
      child = next;
    }
  }
  UsePart(part);
  Withdraw(part);
  const napi_value promise = StartJob(&close->job, part);
  LeavePart(part);
  return promise;
}

void CloseEverything(Env* env, bool loop_runs) {
  pthread_mutex_lock(&env->mutex);
  env->over = true;
  FailRequests(env, NULL, "The program of the service ends.");
  Part* parts = env->parts;
  env->parts = NULL;
  for (Part* part = parts; part != NULL; part = part->next) part->closed = true;
  pthread_mutex_unlock(&env->mutex);
  for (Part* part = parts; part != NULL; part = part->next) {
    if (part->session == NULL) hgros_session_end(part->handle);
  }
  pthread_mutex_lock(&env->mutex);
  while (env->jobs > 0) pthread_cond_wait(&env->changed, &env->mutex);
  pthread_mutex_unlock(&env->mutex);
  // The newest is first in the list, so sessions come after their parts.
  while (parts != NULL) {
    Part* const part = parts;
    parts = part->next;
    if (part->poll != NULL && loop_runs) uv_close((uv_handle_t*)part->poll, FreePoll);
    hgros_schema_free(part->schema);
    CloseHandle(part);
    ReleasePart(part);
  }
  DropArrivals(env);
}
