#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

static void CloseParams(void* params) { (void)hgros_params_close(params); }

// openParams(session, files)
static napi_value OpenParams(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Part* part = NULL;
  hgros_params* params = NULL;
  size_t count = 0;
  Arguments(napi, info, 2, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  char** const files = TextsOf(napi, arguments[1], &count);
  const napi_value value = NewPart(session->env, session, CloseParams, NULL, &part);
  const hgros_status status = hgros_params_open(session->handle, (const char* const*)files, count, &params);
  FreeTexts(files);
  return Opened(part, params, status, value);
}

// openParamsOf(session, name, timeout)
static napi_value OpenParamsOf(napi_env napi, napi_callback_info info) {
  napi_value arguments[3];
  Part* part = NULL;
  hgros_params* params = NULL;
  Arguments(napi, info, 3, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  char* const name = TextOf(napi, arguments[1]);
  const napi_value value = NewPart(session->env, session, CloseParams, NULL, &part);
  const hgros_status status = hgros_params_of(session->handle, name, TimeoutOf(napi, arguments[2]), &params);
  free(name);
  return Opened(part, params, status, value);
}

static Part* ParamsIn(napi_env napi, napi_value value) { return OpenPartOf(napi, value, "The parameters are closed."); }

// What lib/params.js asks for, by number.
enum { kBool, kInteger, kNumber, kText, kYaml, kSet, kRemove, kSave };

typedef struct {
  Job job;
  int operation;
  char* path;
  char* yaml;  // To set.
  int32_t truth;
  int64_t integer;
  double number;
  char* text;
} ParamJob;

static hgros_status RunParam(hgros_params* params, ParamJob* job) {
  switch (job->operation) {
    case kBool: return hgros_params_get_bool(params, job->path, &job->truth);
    case kInteger: return hgros_params_get_integer(params, job->path, &job->integer);
    case kNumber: return hgros_params_get_number(params, job->path, &job->number);
    case kText: return hgros_params_get_text(params, job->path, &job->text);
    case kYaml: return hgros_params_get(params, job->path, &job->text);
    case kSet: return hgros_params_set(params, job->path, job->yaml);
    case kRemove: return hgros_params_remove(params, job->path);
    default: return hgros_params_save(params);
  }
}

static void WorkParam(Job* job) { JobEnded(job, RunParam(job->part->handle, (ParamJob*)job)); }

static napi_value ParamResult(napi_env napi, Job* job) {
  const ParamJob* const param = (ParamJob*)job;
  switch (param->operation) {
    case kBool: return Truth(napi, param->truth != 0);
    case kInteger: return Integer(napi, param->integer);
    case kNumber: return Number(napi, param->number);
    case kText:
    case kYaml: return Text(napi, param->text);
    default: return Undefined(napi);
  }
}

static void FreeParam(Job* job) {
  ParamJob* const param = (ParamJob*)job;
  free(param->path);
  free(param->yaml);
  hgros_text_free(param->text);
  free(job);
}

static ParamJob* NewParamJob(napi_env napi, const napi_value* arguments) {
  ParamJob* const job = calloc(1, sizeof *job);
  job->job.work = WorkParam;
  job->job.result = ParamResult;
  job->job.free = FreeParam;
  job->operation = (int)NumberOf(napi, arguments[1]);
  job->path = TextOf(napi, arguments[2]);
  job->yaml = TextOf(napi, arguments[3]);
  return job;
}

// param(params, operation, path, yaml): of this program, which does not wait.
static napi_value Param(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  Arguments(napi, info, 4, arguments);
  Part* const params = ParamsIn(napi, arguments[0]);
  if (params == NULL) return NULL;
  ParamJob* const job = NewParamJob(napi, arguments);
  const hgros_status status = RunParam(params->handle, job);
  const napi_value value = status == HGROS_OK ? ParamResult(napi, &job->job) : Checked(napi, status);
  FreeParam(&job->job);
  return value;
}

// paramLater(params, operation, path, yaml): of another session. A promise.
static napi_value ParamLater(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  Arguments(napi, info, 4, arguments);
  Part* const params = ParamsIn(napi, arguments[0]);
  return params != NULL ? StartJob(&NewParamJob(napi, arguments)->job, params) : NULL;
}

// declareParam(params, path, kind, fallback as YAML, {readOnly, description, unit, least, most, choices})
static napi_value DeclareParam(napi_env napi, napi_callback_info info) {
  napi_value arguments[5];
  hgros_param_info about = {.size = sizeof about};
  Arguments(napi, info, 5, arguments);
  Part* const params = ParamsIn(napi, arguments[0]);
  if (params == NULL) return NULL;
  char* const path = TextOf(napi, arguments[1]);
  char* const fallback = TextOf(napi, arguments[3]);
  const napi_value least = FieldOf(napi, arguments[4], "least");
  const napi_value most = FieldOf(napi, arguments[4], "most");
  char* const description = TextOf(napi, FieldOf(napi, arguments[4], "description"));
  char* const unit = TextOf(napi, FieldOf(napi, arguments[4], "unit"));
  char** const choices = TextsOf(napi, FieldOf(napi, arguments[4], "choices"), &about.choice_count);
  about.read_only = TruthOf(napi, FieldOf(napi, arguments[4], "readOnly"));
  about.description = description;
  about.unit = unit;
  about.has_least = napi_get_value_double(napi, least, &about.least) == napi_ok;
  about.has_most = napi_get_value_double(napi, most, &about.most) == napi_ok;
  about.choices = (const char* const*)choices;
  const hgros_status status =
      hgros_params_declare(params->handle, path, (int32_t)NumberOf(napi, arguments[2]), fallback, &about);
  free(path);
  free(fallback);
  free(description);
  free(unit);
  FreeTexts(choices);
  return Checked(napi, status);
}

typedef struct {
  Arrival arrival;
  Part* watch;
  char* path;
  char* yaml;  // NULL: removed.
} Change;

static void ShowChange(Env* env, Arrival* arrival) {
  Change* const change = (Change*)arrival;
  if (env != NULL && change->watch->callback != NULL) {
    const napi_value arguments[] = {Text(env->napi, change->path),
                                    change->yaml != NULL ? Text(env->napi, change->yaml) : Undefined(env->napi)};
    CallBack(env, change->watch->callback, 2, arguments);
  }
  ReleasePart(change->watch);
  free(change->path);
  free(change->yaml);
  free(change);
}

// Any thread.
static void Changed(void* user, const char* path, const char* yaml) {
  Part* const watch = user;
  Change* const change = calloc(1, sizeof *change);
  change->arrival.run = ShowChange;
  change->watch = watch;
  change->path = strdup(path);
  change->yaml = yaml != NULL ? strdup(yaml) : NULL;
  RetainPart(watch);
  Post(watch->env, &change->arrival);
}

static void CloseWatch(void* watch) { hgros_watch_close(watch); }

// watchParams(params, path, changed)
static napi_value WatchParams(napi_env napi, napi_callback_info info) {
  napi_value arguments[3];
  Part* part = NULL;
  hgros_watch* watch = NULL;
  Arguments(napi, info, 3, arguments);
  Part* const params = ParamsIn(napi, arguments[0]);
  if (params == NULL) return NULL;
  char* const path = TextOf(napi, arguments[1]);
  const napi_value value = NewPart(params->env, params->session, CloseWatch, arguments[2], &part);
  part->keeps_awake = true;
  const hgros_status status = hgros_params_watch(params->handle, path, Changed, part, NULL, &watch);
  free(path);
  return Opened(part, watch, status, value);
}

// closeParams(params): a promise.
static napi_value CloseParamsLater(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  return ClosePartLater(PartOf(napi, argument));
}

void DefineParams(napi_env napi, napi_value exports) {
  Define(napi, exports, "openParams", OpenParams);
  Define(napi, exports, "openParamsOf", OpenParamsOf);
  Define(napi, exports, "param", Param);
  Define(napi, exports, "paramLater", ParamLater);
  Define(napi, exports, "declareParam", DeclareParam);
  Define(napi, exports, "watchParams", WatchParams);
  Define(napi, exports, "closeParams", CloseParamsLater);
}
