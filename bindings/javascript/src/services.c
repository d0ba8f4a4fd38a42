#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

static void CloseService(void* service) { hgros_service_close(service); }

static void End(Request* request, char* failure) {
  if (request->done) {
    free(failure);
    return;
  }
  request->done = true;
  request->failure = failure;
  pthread_cond_signal(&request->answered);
}

void FailRequests(Env* env, const Part* session, const char* sentence) {
  for (Request* request = env->requests; request != NULL; request = request->next) {
    if (session == NULL || request->service->session == session) End(request, strdup(sentence));
  }
}

// Its service was closed before JavaScript saw it.
static void FailRequest(Env* env, uint64_t number) {
  pthread_mutex_lock(&env->mutex);
  Request* request = env->requests;
  while (request != NULL && request->number != number) request = request->next;
  if (request != NULL) End(request, strdup("The service is closed."));
  pthread_mutex_unlock(&env->mutex);
}

typedef struct {
  Arrival arrival;
  Part* service;
  uint64_t number;
  hgros_message* message;
} RequestArrival;

static void ShowRequest(Env* env, Arrival* arrival) {
  RequestArrival* const request = (RequestArrival*)arrival;
  if (env == NULL || request->service->callback == NULL) {  // Without the loop, all requests are failed together.
    hgros_message_free(request->message);
    if (env != NULL) FailRequest(env, request->number);
  } else {
    const napi_value arguments[] = {BigId(env->napi, request->number), BufferOf(env->napi, request->message)};
    CallBack(env, request->service->callback, 2, arguments);
  }
  ReleasePart(request->service);
  free(request);
}

// On a thread of the service, which waits for JavaScript.
static void Handle(void* user, const hgros_message* asked, hgros_reply* reply) {
  static uint64_t last_number = 0;
  Part* const service = user;
  Env* const env = service->env;
  Request request = {.service = service, .answered = PTHREAD_COND_INITIALIZER};
  RequestArrival* const arrival = calloc(1, sizeof *arrival);
  arrival->arrival.run = ShowRequest;
  arrival->service = service;
  hgros_message_keep(asked, &arrival->message);
  RetainPart(service);

  pthread_mutex_lock(&env->mutex);
  request.number = arrival->number = __atomic_add_fetch(&last_number, 1, __ATOMIC_RELAXED);
  request.next = env->requests;
  env->requests = &request;
  if (env->over || service->closed) End(&request, strdup("The service is closed."));
  pthread_mutex_unlock(&env->mutex);

  Post(env, &arrival->arrival);

  pthread_mutex_lock(&env->mutex);
  while (!request.done) pthread_cond_wait(&request.answered, &env->mutex);
  Request** place = &env->requests;
  while (*place != &request) place = &(*place)->next;
  *place = request.next;
  pthread_mutex_unlock(&env->mutex);

  if (request.failure != NULL) {
    hgros_reply_fail(reply, request.failure);
  } else {
    hgros_reply_set(reply, request.data, request.size);
  }
  free(request.failure);
  free(request.data);
}

// serve(session, name, request schema, reply schema, requests that may wait, handler)
static napi_value Serve(napi_env napi, napi_callback_info info) {
  napi_value arguments[6];
  Part* part = NULL;
  hgros_service* service = NULL;
  hgros_serve_options options = {.size = sizeof options};
  Arguments(napi, info, 6, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  options.most_waiting = (uint64_t)NumberOf(napi, arguments[4]);
  options.executor = HGROS_EXECUTOR_DEDICATED;  // The thread waits for JavaScript, and must not hold up others.
  char* const name = TextOf(napi, arguments[1]);
  const napi_value value = NewPart(session->env, session, CloseService, arguments[5], &part);
  part->keeps_awake = true;
  const hgros_status status = hgros_serve(session->handle, name, SchemaOf(napi, arguments[2]),
                                          SchemaOf(napi, arguments[3]), &options, Handle, part, NULL, &service);
  free(name);
  return Opened(part, service, status, value);
}

static void Answer(napi_env napi, napi_value number, char* failure, void* data, size_t size) {
  Env* const env = EnvOf(napi);
  uint64_t wanted = 0;
  bool lossless = false;
  napi_get_value_bigint_uint64(napi, number, &wanted, &lossless);
  pthread_mutex_lock(&env->mutex);
  Request* request = env->requests;
  while (request != NULL && request->number != wanted) request = request->next;
  if (request != NULL && !request->done) {
    request->data = data;
    request->size = size;
    data = NULL;
    End(request, failure);
    failure = NULL;
  }
  pthread_mutex_unlock(&env->mutex);
  free(failure);
  free(data);
}

// reply(number, buffer)
static napi_value Reply(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  size_t size = 0;
  Arguments(napi, info, 2, arguments);
  const void* const data = BytesOf(napi, arguments[1], &size);
  void* const copy = malloc(size + 1);
  memcpy(copy, data, size);
  Answer(napi, arguments[0], NULL, copy, size);
  return Undefined(napi);
}

// fail(number, sentence)
static napi_value Fail(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Arguments(napi, info, 2, arguments);
  Answer(napi, arguments[0], TextOf(napi, arguments[1]), NULL, 0);
  return Undefined(napi);
}

// closeService(service): a promise.
static napi_value CloseServiceLater(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  return ClosePartLater(PartOf(napi, argument));
}

typedef struct {
  Env* env;
  napi_ref done;
  hgros_pending_call* handle;
} Call;

typedef struct {
  Arrival arrival;
  Call* call;
  hgros_status status;
  char* sentence;
  hgros_message* reply;
} ReplyArrival;

static void ShowReply(Env* env, Arrival* arrival) {
  ReplyArrival* const end = (ReplyArrival*)arrival;
  if (env == NULL) {
    hgros_message_free(end->reply);
  } else {
    KeepAwake(env, -1);
    const bool good = end->status == HGROS_OK;
    const napi_value arguments[] = {good ? Undefined(env->napi) : ErrorOf(env->napi, end->status, end->sentence),
                                    good ? BufferOf(env->napi, end->reply) : Undefined(env->napi)};
    CallBack(env, end->call->done, 2, arguments);
    napi_delete_reference(env->napi, end->call->done);
  }
  end->call->done = NULL;
  free(end->sentence);
  free(end);
}

// Any thread.
static void Replied(void* user, hgros_status status, const char* sentence, const hgros_message* reply) {
  Call* const call = user;
  ReplyArrival* const end = calloc(1, sizeof *end);
  end->arrival.run = ShowReply;
  end->call = call;
  end->status = status;
  end->sentence = strdup(sentence != NULL ? sentence : "");
  if (reply != NULL) hgros_message_keep(reply, &end->reply);
  Post(call->env, &end->arrival);
}

static void ForgetCall(napi_env napi, void* data, void* nothing) {
  Call* const call = data;
  (void)napi;
  (void)nothing;
  hgros_call_free(call->handle);
  free(call);
}

// call(session, name, request schema, buffer, reply schema or undefined, timeout, done): what cancelCall() takes.
// `done` gets an error or a Buffer; it holds the result of this function, which must not be forgotten before.
static napi_value StartCall(napi_env napi, napi_callback_info info) {
  napi_value arguments[7];
  napi_value value = NULL;
  size_t size = 0;
  Arguments(napi, info, 7, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  Call* const call = calloc(1, sizeof *call);
  call->env = session->env;
  napi_create_reference(napi, arguments[6], 1, &call->done);
  char* const name = TextOf(napi, arguments[1]);
  const void* const data = BytesOf(napi, arguments[3], &size);
  const hgros_status status =
      hgros_call_later(session->handle, name, SchemaOf(napi, arguments[2]), data, size, SchemaOf(napi, arguments[4]),
                       TimeoutOf(napi, arguments[5]), Replied, call, NULL, &call->handle);
  free(name);
  if (status != HGROS_OK) {
    napi_delete_reference(napi, call->done);
    free(call);
    return Checked(napi, status);
  }
  KeepAwake(session->env, 1);
  napi_create_external(napi, call, ForgetCall, NULL, &value);
  return value;
}

// cancelCall(call)
static napi_value CancelCall(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  void* call = NULL;
  Arguments(napi, info, 1, &argument);
  if (napi_get_value_external(napi, argument, &call) == napi_ok) hgros_call_cancel(((Call*)call)->handle);
  return Undefined(napi);
}

void DefineServices(napi_env napi, napi_value exports) {
  Define(napi, exports, "serve", Serve);
  Define(napi, exports, "reply", Reply);
  Define(napi, exports, "fail", Fail);
  Define(napi, exports, "closeService", CloseServiceLater);
  Define(napi, exports, "call", StartCall);
  Define(napi, exports, "cancelCall", CancelCall);
}
