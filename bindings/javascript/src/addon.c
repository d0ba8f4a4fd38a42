#include "addon.h"

#include <stdlib.h>

#include "value.h"

// The environments that have not ended, of all threads.
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static Env* environments;

Env* EnvOf(napi_env napi) {
  void* env = NULL;
  napi_get_instance_data(napi, &env);
  return env;
}

void KeepAwake(Env* env, int change) {
  const bool was_awake = env->awake > 0;
  env->awake += (size_t)change;
  if (was_awake == (env->awake > 0)) return;
  if (was_awake) {
    uv_unref((uv_handle_t*)&env->bell);
  } else {
    uv_ref((uv_handle_t*)&env->bell);
  }
}

void ReleaseEnv(Env* env) {
  pthread_mutex_lock(&env->mutex);
  const bool last = --env->refs == 0;
  pthread_mutex_unlock(&env->mutex);
  if (!last) return;
  pthread_mutex_destroy(&env->mutex);
  pthread_cond_destroy(&env->changed);
  free(env);
}

void UvHandleClosed(Env* env) {
  if (--env->uv_handles == 0 && env->over) napi_remove_async_cleanup_hook(env->cleanup);
}

static void BellClosed(uv_handle_t* bell) { UvHandleClosed(bell->data); }

static void Forget(Env* env) {
  pthread_mutex_lock(&mutex);
  for (Env** place = &environments; *place != NULL; place = &(*place)->next) {
    if (*place == env) {
      *place = env->next;
      break;
    }
  }
  pthread_mutex_unlock(&mutex);
}

// A worker thread ends, or the main program without process.exit().
static void CleanUp(napi_async_cleanup_hook_handle handle, void* data) {
  Env* const env = data;
  (void)handle;
  Forget(env);
  CloseEverything(env, true);
  uv_close((uv_handle_t*)&env->bell, BellClosed);
}

static void Finalize(napi_env napi, void* env, void* nothing) {
  (void)napi;
  (void)nothing;
  ReleaseEnv(env);
}

// process.exit() runs no hooks in the main program. Its worker threads have ended by then.
static void CloseAtExit(void) {
  for (Env* env = environments; env != NULL; env = env->next) CloseEverything(env, false);
}

static void RegisterExit(void) { atexit(CloseAtExit); }

// setUp(HgrosError): the memory where take() writes what it knows of a message.
static napi_value SetUp(napi_env napi, napi_callback_info info) {
  Env* const env = EnvOf(napi);
  const size_t count = 8;
  napi_value error_class = NULL;
  napi_value buffer = NULL;
  napi_value numbers = NULL;
  void* memory = NULL;
  Arguments(napi, info, 1, &error_class);
  napi_create_reference(napi, error_class, 1, &env->error_class);
  napi_create_arraybuffer(napi, count * sizeof *env->numbers, &memory, &buffer);
  napi_create_typedarray(napi, napi_bigint64_array, count, buffer, 0, &numbers);
  napi_create_reference(napi, numbers, 1, &env->scratch);
  env->numbers = memory;
  return numbers;
}

NAPI_MODULE_INIT() {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  uv_loop_t* loop = NULL;
  napi_value name = NULL;
  Env* const made = calloc(1, sizeof *made);
  made->napi = env;
  made->refs = 1;
  pthread_mutex_init(&made->mutex, NULL);
  pthread_cond_init(&made->changed, NULL);
  napi_set_instance_data(env, made, Finalize, NULL);
  napi_get_uv_event_loop(env, &loop);
  OpenInbox(made, loop);
  napi_create_string_utf8(env, "hgros", NAPI_AUTO_LENGTH, &name);
  napi_async_init(env, NULL, name, &made->context);
  napi_add_async_cleanup_hook(env, CleanUp, made, &made->cleanup);
  pthread_mutex_lock(&mutex);
  made->next = environments;
  environments = made;
  pthread_mutex_unlock(&mutex);
  pthread_once(&once, RegisterExit);

  Define(env, exports, "setUp", SetUp);
  DefineMessages(env, exports);
  DefineObservation(env, exports);
  DefineParams(env, exports);
  DefinePublishing(env, exports);
  DefineServices(env, exports);
  DefineSessions(env, exports);
  DefineSubscribing(env, exports);
  DefineTransforms(env, exports);
  return exports;
}
