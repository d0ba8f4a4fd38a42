#include <stdlib.h>

#include "addon.h"
#include "value.h"

static void CloseTransforms(void* transforms) { (void)hgros_transforms_close(transforms); }

// openTransforms(session)
static napi_value OpenTransforms(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Part* part = NULL;
  hgros_transforms* transforms = NULL;
  Arguments(napi, info, 1, &argument);
  Part* const session = OpenPartOf(napi, argument, "The session is closed.");
  if (session == NULL) return NULL;
  const napi_value value = NewPart(session->env, session, CloseTransforms, NULL, &part);
  const hgros_status status = hgros_transforms_open(session->handle, &transforms);
  return Opened(part, transforms, status, value);
}

static Part* TransformsIn(napi_env napi, napi_value value) {
  return OpenPartOf(napi, value, "The transforms are closed.");
}

static void NumbersOf(napi_env napi, napi_value array, uint32_t count, double* numbers) {
  for (uint32_t i = 0; i < count; ++i) {
    napi_value element = NULL;
    napi_get_element(napi, array, i, &element);
    numbers[i] = NumberOf(napi, element);
  }
}

static napi_value Numbers(napi_env napi, uint32_t count, const double* numbers) {
  napi_value array = NULL;
  napi_create_array_with_length(napi, count, &array);
  for (uint32_t i = 0; i < count; ++i) napi_set_element(napi, array, i, Number(napi, numbers[i]));
  return array;
}

static napi_value TransformFrom(napi_env napi, const hgros_transform* found) {
  napi_value object = NULL;
  napi_create_object(napi, &object);
  Set(napi, object, "translation", Numbers(napi, 3, found->translation));
  Set(napi, object, "rotation", Numbers(napi, 4, found->rotation));
  Set(napi, object, "stamp", BigTime(napi, found->stamp_ns));
  return object;
}

// setTransform(transforms, parent, child, {translation, rotation, stamp}, is static)
static napi_value SetTransform(napi_env napi, napi_callback_info info) {
  napi_value arguments[5];
  hgros_transform pose = {{0}, {0}, 0};
  Arguments(napi, info, 5, arguments);
  Part* const transforms = TransformsIn(napi, arguments[0]);
  if (transforms == NULL) return NULL;
  char* const parent = TextOf(napi, arguments[1]);
  char* const child = TextOf(napi, arguments[2]);
  NumbersOf(napi, FieldOf(napi, arguments[3], "translation"), 3, pose.translation);
  NumbersOf(napi, FieldOf(napi, arguments[3], "rotation"), 4, pose.rotation);
  pose.stamp_ns = IntegerOf(napi, FieldOf(napi, arguments[3], "stamp"));
  const hgros_status status = TruthOf(napi, arguments[4])
                                  ? hgros_transforms_set_static(transforms->handle, parent, child, &pose)
                                  : hgros_transforms_set(transforms->handle, parent, child, &pose);
  free(parent);
  free(child);
  return Checked(napi, status);
}

// lookUp(transforms, target, source, time or undefined)
static napi_value LookUp(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  napi_valuetype time_type = napi_undefined;
  hgros_transform found;
  Arguments(napi, info, 4, arguments);
  Part* const transforms = TransformsIn(napi, arguments[0]);
  if (transforms == NULL) return NULL;
  char* const target = TextOf(napi, arguments[1]);
  char* const source = TextOf(napi, arguments[2]);
  napi_typeof(napi, arguments[3], &time_type);
  const hgros_status status =
      time_type == napi_bigint
          ? hgros_transforms_lookup_at(transforms->handle, target, source, IntegerOf(napi, arguments[3]), &found)
          : hgros_transforms_lookup(transforms->handle, target, source, &found);
  free(target);
  free(source);
  return status == HGROS_OK ? TransformFrom(napi, &found) : Checked(napi, status);
}

typedef struct {
  Job job;
  char* target;
  char* source;
  int64_t time_ns;
  int64_t timeout_ns;
  hgros_transform found;
} WaitJob;

static void WorkWait(Job* job) {
  WaitJob* const wait = (WaitJob*)job;
  JobEnded(job, hgros_transforms_wait(job->part->handle, wait->target, wait->source, wait->time_ns, wait->timeout_ns,
                                      &wait->found));
}

static napi_value WaitResult(napi_env napi, Job* job) { return TransformFrom(napi, &((WaitJob*)job)->found); }

static void FreeWait(Job* job) {
  WaitJob* const wait = (WaitJob*)job;
  free(wait->target);
  free(wait->source);
  free(job);
}

// waitForTransform(transforms, target, source, time, timeout): a promise.
static napi_value WaitForTransform(napi_env napi, napi_callback_info info) {
  napi_value arguments[5];
  Arguments(napi, info, 5, arguments);
  Part* const transforms = TransformsIn(napi, arguments[0]);
  if (transforms == NULL) return NULL;
  WaitJob* const job = calloc(1, sizeof *job);
  job->job.work = WorkWait;
  job->job.result = WaitResult;
  job->job.free = FreeWait;
  job->target = TextOf(napi, arguments[1]);
  job->source = TextOf(napi, arguments[2]);
  job->time_ns = IntegerOf(napi, arguments[3]);
  job->timeout_ns = TimeoutOf(napi, arguments[4]);
  return StartJob(&job->job, transforms);
}

// closeTransforms(transforms): a promise.
static napi_value CloseTransformsLater(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  return ClosePartLater(PartOf(napi, argument));
}

void DefineTransforms(napi_env napi, napi_value exports) {
  Define(napi, exports, "openTransforms", OpenTransforms);
  Define(napi, exports, "setTransform", SetTransform);
  Define(napi, exports, "lookUp", LookUp);
  Define(napi, exports, "waitForTransform", WaitForTransform);
  Define(napi, exports, "closeTransforms", CloseTransformsLater);
}
