#include <stdlib.h>

#include "addon.h"

static Arrival* TakeAll(Env* env) {
  pthread_mutex_lock(&env->mutex);
  Arrival* const first = env->first;
  env->first = NULL;
  env->last = NULL;
  pthread_mutex_unlock(&env->mutex);
  return first;
}

static void Deliver(uv_async_t* bell) {
  Env* const env = bell->data;
  for (Arrival* arrival = TakeAll(env); arrival != NULL;) {
    Arrival* const next = arrival->next;
    napi_handle_scope scope;
    napi_open_handle_scope(env->napi, &scope);
    arrival->run(env, arrival);
    napi_close_handle_scope(env->napi, scope);
    arrival = next;
  }
}

void OpenInbox(Env* env, uv_loop_t* loop) {
  uv_async_init(loop, &env->bell, Deliver);
  env->bell.data = env;
  env->uv_handles = 1;
  uv_unref((uv_handle_t*)&env->bell);
}

void Post(Env* env, Arrival* arrival) {
  arrival->next = NULL;
  pthread_mutex_lock(&env->mutex);
  const bool over = env->over;
  if (!over) {
    if (env->last != NULL) {
      env->last->next = arrival;
    } else {
      env->first = arrival;
    }
    env->last = arrival;
    uv_async_send(&env->bell);
  }
  pthread_mutex_unlock(&env->mutex);
  if (over) arrival->run(NULL, arrival);
}

void DropArrivals(Env* env) {
  for (Arrival* arrival = TakeAll(env); arrival != NULL;) {
    Arrival* const next = arrival->next;
    arrival->run(NULL, arrival);
    arrival = next;
  }
}

void CallBack(Env* env, napi_ref function, size_t count, const napi_value* arguments) {
  napi_value callee = NULL;
  napi_value global = NULL;
  napi_value result = NULL;
  napi_get_reference_value(env->napi, function, &callee);
  napi_get_global(env->napi, &global);
  if (napi_make_callback(env->napi, env->context, global, callee, count, arguments, &result) !=
      napi_pending_exception) {
    return;
  }
  napi_value thrown = NULL;
  if (napi_get_and_clear_last_exception(env->napi, &thrown) == napi_ok) napi_fatal_exception(env->napi, thrown);
}
