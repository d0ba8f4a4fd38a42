#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

// What the log of one session needs on any thread. Freed by the release of the library and JavaScript's own, in turn.
typedef struct {
  Env* env;
  napi_ref function;
} Log;

typedef struct {
  Arrival arrival;
  Log* log;
  int32_t level;
  char* text;  // NULL: the last one. No line can come any more.
} Line;

static void ShowLine(Env* env, Arrival* arrival) {
  Line* const line = (Line*)arrival;
  if (line->text == NULL) {
    if (env != NULL) napi_delete_reference(env->napi, line->log->function);
    free(line->log);
  } else if (env != NULL) {
    const napi_value arguments[] = {Number(env->napi, line->level), Text(env->napi, line->text)};
    CallBack(env, line->log->function, 2, arguments);
  } else {
    fprintf(stderr, "%s\n", line->text);  // JavaScript has ended. This is where the log goes without a function.
  }
  free(line->text);
  free(line);
}

static void PostLine(Log* log, int32_t level, char* text) {
  Line* const line = calloc(1, sizeof *line);
  line->arrival.run = ShowLine;
  line->log = log;
  line->level = level;
  line->text = text;
  Post(log->env, &line->arrival);
}

static void OnLine(void* user, int32_t level, const char* text) { PostLine(user, level, strdup(text)); }

static void OnLastLine(void* user) { PostLine(user, 0, NULL); }

static void CloseSession(void* session) { hgros_session_close(session); }

// openSession(yaml or undefined, files or undefined, name or undefined, function of the log or undefined)
static napi_value OpenSession(napi_env napi, napi_callback_info info) {
  Env* const env = EnvOf(napi);
  napi_value arguments[4];
  napi_valuetype log_type = napi_undefined;
  bool has_files = false;
  Part* part = NULL;
  hgros_session* session = NULL;
  hgros_session_options options = {.size = sizeof options};
  Arguments(napi, info, 4, arguments);
  char* const yaml = TextOf(napi, arguments[0]);
  char* const name = TextOf(napi, arguments[2]);
  options.name = name;
  napi_is_array(napi, arguments[1], &has_files);
  napi_typeof(napi, arguments[3], &log_type);
  if (log_type == napi_function) {
    Log* const log = calloc(1, sizeof *log);
    log->env = env;
    napi_create_reference(napi, arguments[3], 1, &log->function);
    options.log = OnLine;
    options.log_user = log;
    options.log_release = OnLastLine;
  }
  const napi_value value = NewPart(env, NULL, CloseSession, NULL, &part);
  hgros_status status = HGROS_OK;
  if (has_files) {
    size_t count = 0;
    char** const files = TextsOf(napi, arguments[1], &count);
    status = hgros_session_open_files((const char* const*)files, count, &options, &session);
    FreeTexts(files);
  } else {
    status = hgros_session_open(yaml, &options, &session);
  }
  free(yaml);
  free(name);
  return Opened(part, session, status, value);
}

// closeSession(session): a promise. The session and its parts are closed for every later call.
static napi_value CloseSessionLater(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  return ClosePartLater(PartOf(napi, argument));
}

static hgros_session* SessionIn(napi_env napi, napi_value value) {
  Part* const part = OpenPartOf(napi, value, "The session is closed.");
  return part != NULL ? part->handle : NULL;
}

static napi_value SessionId(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  hgros_session* const session = SessionIn(napi, argument);
  return session != NULL ? BigId(napi, hgros_session_id(session)) : NULL;
}

static napi_value SessionName(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  hgros_session* const session = SessionIn(napi, argument);
  return session != NULL ? Text(napi, hgros_session_name(session)) : NULL;
}

static napi_value SessionNow(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  hgros_session* const session = SessionIn(napi, argument);
  return session != NULL ? BigTime(napi, hgros_session_now(session)) : NULL;
}

// log(session, level, text, alike): `alike` is undefined for lines that do not repeat.
static napi_value WriteLog(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  Arguments(napi, info, 4, arguments);
  hgros_session* const session = SessionIn(napi, arguments[0]);
  if (session == NULL) return NULL;
  const int32_t level = (int32_t)NumberOf(napi, arguments[1]);
  char* const text = TextOf(napi, arguments[2]);
  char* const alike = TextOf(napi, arguments[3]);
  const hgros_status status =
      alike == NULL ? hgros_session_log(session, level, text) : hgros_session_log_limited(session, level, alike, text);
  free(alike);
  free(text);
  return Checked(napi, status);
}

// setLogLevel(session, level)
static napi_value SetLogLevel(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Arguments(napi, info, 2, arguments);
  hgros_session* const session = SessionIn(napi, arguments[0]);
  if (session == NULL) return NULL;
  return Checked(napi, hgros_session_set_log_level(session, (int32_t)NumberOf(napi, arguments[1])));
}

typedef struct {
  Job job;
  char* channel;
  size_t count;
  int64_t timeout_ns;
  hgros_status (*wait)(const hgros_session*, const char*, size_t, int64_t);
} WaitJob;

static void WorkWait(Job* job) {
  WaitJob* const wait = (WaitJob*)job;
  JobEnded(job, wait->wait(job->part->handle, wait->channel, wait->count, wait->timeout_ns));
}

static void FreeWait(Job* job) {
  free(((WaitJob*)job)->channel);
  free(job);
}

// (session, channel, count, timeout): a promise.
static napi_value WaitFor(napi_env napi, napi_callback_info info,
                          hgros_status (*wait)(const hgros_session*, const char*, size_t, int64_t)) {
  napi_value arguments[4];
  Arguments(napi, info, 4, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  WaitJob* const job = calloc(1, sizeof *job);
  job->job.work = WorkWait;
  job->job.free = FreeWait;
  job->channel = TextOf(napi, arguments[1]);
  job->count = (size_t)NumberOf(napi, arguments[2]);
  job->timeout_ns = TimeoutOf(napi, arguments[3]);
  job->wait = wait;
  return StartJob(&job->job, session);
}

static napi_value WaitForSubscribers(napi_env napi, napi_callback_info info) {
  return WaitFor(napi, info, hgros_session_wait_for_subscribers);
}

static napi_value WaitForPublishers(napi_env napi, napi_callback_info info) {
  return WaitFor(napi, info, hgros_session_wait_for_publishers);
}

void DefineSessions(napi_env napi, napi_value exports) {
  Define(napi, exports, "openSession", OpenSession);
  Define(napi, exports, "closeSession", CloseSessionLater);
  Define(napi, exports, "sessionId", SessionId);
  Define(napi, exports, "sessionName", SessionName);
  Define(napi, exports, "sessionNow", SessionNow);
  Define(napi, exports, "log", WriteLog);
  Define(napi, exports, "setLogLevel", SetLogLevel);
  Define(napi, exports, "waitForSubscribers", WaitForSubscribers);
  Define(napi, exports, "waitForPublishers", WaitForPublishers);
}
