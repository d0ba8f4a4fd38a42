#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

static void CloseQueue(void* queue) { hgros_subscription_close(queue); }

static void Readable(uv_poll_t* poll, int status, int events) {
  Part* const queue = poll->data;
  Env* const env = queue->env;
  napi_handle_scope scope;
  (void)status;
  (void)events;
  napi_open_handle_scope(env->napi, &scope);
  CallBack(env, queue->callback, 0, NULL);
  napi_close_handle_scope(env->napi, scope);
}

// openQueue(session, channel, {name, schema, keepLast, keepAll, keepAllBytes}, readable)
static napi_value OpenQueue(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  Part* part = NULL;
  uv_loop_t* loop = NULL;
  hgros_subscription* queue = NULL;
  hgros_subscribe_options options = {.size = sizeof options};
  Arguments(napi, info, 4, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  char* const channel = TextOf(napi, arguments[1]);
  char* const name = TextOf(napi, FieldOf(napi, arguments[2], "name"));
  options.name = name;
  options.schema = SchemaOf(napi, FieldOf(napi, arguments[2], "schema"));
  options.keep_last = (uint64_t)NumberOf(napi, FieldOf(napi, arguments[2], "keepLast"));
  options.keep_all = (uint64_t)NumberOf(napi, FieldOf(napi, arguments[2], "keepAll"));
  options.keep_all_bytes = (uint64_t)NumberOf(napi, FieldOf(napi, arguments[2], "keepAllBytes"));
  const napi_value value = NewPart(session->env, session, CloseQueue, arguments[3], &part);
  const hgros_status status = hgros_subscribe_queue(session->handle, channel, &options, &queue);
  free(channel);
  free(name);
  if (Opened(part, queue, status, value) == NULL) return NULL;
  napi_get_uv_event_loop(napi, &loop);
  if (AddPoll(part, loop, hgros_queue_descriptor(queue))) return value;
  ClosePart(part);
  return Throw(napi, HGROS_ERROR, "The event loop cannot watch the descriptor of the queue.");
}

// watchQueue(queue, wanted): whether `readable` is called in turns of the loop in which messages wait. Only then the
// queue keeps the program from ending.
static napi_value WatchQueue(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Arguments(napi, info, 2, arguments);
  Part* const queue = PartOf(napi, arguments[0]);
  if (queue->closed) return Undefined(napi);
  if (TruthOf(napi, arguments[1])) {
    uv_poll_start(queue->poll, UV_READABLE, Readable);
  } else {
    uv_poll_stop(queue->poll);
  }
  return Undefined(napi);
}

static void NoteSchema(Part* queue, const hgros_schema* came, bool* is_new) {
  size_t size = 0;
  const hgros_schema* const known = queue->schema;
  *is_new = known == NULL || hgros_schema_fingerprint(known) != hgros_schema_fingerprint(came) ||
            hgros_schema_encoding(known) != hgros_schema_encoding(came) ||
            strcmp(hgros_schema_type_name(known), hgros_schema_type_name(came)) != 0;
  if (!*is_new) return;
  hgros_schema_free(queue->schema);
  queue->schema = NULL;
  const void* const set = hgros_schema_descriptor_set(came, &size);
  hgros_schema_create(hgros_schema_type_name(came), hgros_schema_encoding(came), hgros_schema_fingerprint(came), set,
                      size, &queue->schema);
}

enum { kRemote, kPublisher, kIncarnation, kSequence, kKey, kPublishMonotonic, kPublishTime, kNewSchema };

// take(queue): the bytes of the oldest message, or undefined. setUp() returned where the rest is.
static napi_value Take(napi_env napi, napi_callback_info info) {
  Env* const env = EnvOf(napi);
  napi_value argument = NULL;
  bool is_new = false;
  hgros_message* message = NULL;
  hgros_message_info about = {.size = sizeof about};
  Arguments(napi, info, 1, &argument);
  Part* const queue = OpenPartOf(napi, argument, "The subscription is closed.");
  if (queue == NULL) return NULL;
  const hgros_status status = hgros_queue_take(queue->handle, 0, &message);
  if (status == HGROS_TIMED_OUT) return Undefined(napi);
  if (status != HGROS_OK) return Checked(napi, status);
  hgros_message_get_info(message, &about);
  NoteSchema(queue, hgros_message_schema(message), &is_new);
  env->numbers[kRemote] = about.remote;
  env->numbers[kPublisher] = (int64_t)about.publisher;
  env->numbers[kIncarnation] = (int64_t)about.incarnation;
  env->numbers[kSequence] = (int64_t)about.sequence;
  env->numbers[kKey] = (int64_t)about.key;
  env->numbers[kPublishMonotonic] = about.publish_monotonic_ns;
  env->numbers[kPublishTime] = about.publish_time_ns;
  env->numbers[kNewSchema] = is_new;
  return BufferOf(napi, message);
}

// schemaOfQueue(queue): a copy of the type of the message that was taken last; undefined if its sender named none.
static napi_value SchemaOfQueue(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  size_t size = 0;
  hgros_schema* copy = NULL;
  Arguments(napi, info, 1, &argument);
  const hgros_schema* const schema = PartOf(napi, argument)->schema;
  if (schema == NULL) return Undefined(napi);
  const void* const set = hgros_schema_descriptor_set(schema, &size);
  const hgros_status status = hgros_schema_create(hgros_schema_type_name(schema), hgros_schema_encoding(schema),
                                                  hgros_schema_fingerprint(schema), set, size, &copy);
  return status == HGROS_OK ? NewSchema(napi, copy) : Checked(napi, status);
}

// queueStats(queue)
static napi_value QueueStats(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  napi_value object = NULL;
  hgros_subscription_stats stats = {.size = sizeof stats};
  Arguments(napi, info, 1, &argument);
  Part* const queue = OpenPartOf(napi, argument, "The subscription is closed.");
  if (queue == NULL) return NULL;
  const hgros_status status = hgros_subscription_get_stats(queue->handle, &stats);
  if (status != HGROS_OK) return Checked(napi, status);
  napi_create_object(napi, &object);
  Set(napi, object, "received", Number(napi, (double)stats.received));
  Set(napi, object, "dropped", Number(napi, (double)stats.dropped));
  Set(napi, object, "taken", Number(napi, (double)stats.run));
  Set(napi, object, "queued", Number(napi, (double)stats.queued));
  Set(napi, object, "mismatched", Number(napi, (double)stats.mismatched));
  return object;
}

// closeQueue(queue)
static napi_value CloseQueueNow(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  ClosePart(PartOf(napi, argument));
  return Undefined(napi);
}

void DefineSubscribing(napi_env napi, napi_value exports) {
  Define(napi, exports, "openQueue", OpenQueue);
  Define(napi, exports, "watchQueue", WatchQueue);
  Define(napi, exports, "take", Take);
  Define(napi, exports, "schemaOfQueue", SchemaOfQueue);
  Define(napi, exports, "queueStats", QueueStats);
  Define(napi, exports, "closeQueue", CloseQueueNow);
}
