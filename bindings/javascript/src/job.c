#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

// Threads for jobs, of all environments. Those of libuv are few, and belong to the program's files and look-ups of
// names; a job may wait for ever. A thread that has nothing to do waits for the next job.
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t wanted = PTHREAD_COND_INITIALIZER;
static Job* first;
static Job* last;
static size_t waiting;   // Jobs.
static size_t sleeping;  // Threads.

static void EndJob(Job* job) {
  Env* const env = job->env;
  LeavePart(job->part);
  Post(env, &job->arrival);  // The job may be gone now, but not its environment, which waits for the count below.
  pthread_mutex_lock(&env->mutex);
  --env->jobs;
  pthread_cond_broadcast(&env->changed);
  pthread_mutex_unlock(&env->mutex);
}

static void* Work(void* nothing) {
  const size_t most_sleeping = 4;
  (void)nothing;
  pthread_mutex_lock(&mutex);
  for (;;) {
    while (first == NULL) {
      if (sleeping >= most_sleeping) {
        pthread_mutex_unlock(&mutex);
        return NULL;
      }
      ++sleeping;
      pthread_cond_wait(&wanted, &mutex);
      --sleeping;
    }
    Job* const job = first;
    first = job->next;
    if (first == NULL) last = NULL;
    --waiting;
    pthread_mutex_unlock(&mutex);

    job->work(job);
    EndJob(job);
    pthread_mutex_lock(&mutex);
  }
}

static bool StartThread(void) {
  pthread_t thread;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  const bool started = pthread_create(&thread, &attributes, Work, NULL) == 0;
  pthread_attr_destroy(&attributes);
  return started;
}

static void Settle(Env* env, Arrival* arrival) {
  Job* const job = (Job*)arrival;
  if (env != NULL) {
    KeepAwake(env, -1);
    if (job->status == HGROS_OK) {
      napi_resolve_deferred(env->napi, job->deferred,
                            job->result != NULL ? job->result(env->napi, job) : Undefined(env->napi));
    } else {
      napi_reject_deferred(env->napi, job->deferred, ErrorOf(env->napi, job->status, job->sentence));
    }
  }
  free(job->sentence);
  job->free(job);
}

napi_value StartJob(Job* job, Part* part) {
  Env* const env = part->env;
  napi_value promise = NULL;
  napi_create_promise(env->napi, &job->deferred, &promise);
  job->arrival.run = Settle;
  job->env = env;
  job->part = part;
  UsePart(part);
  KeepAwake(env, 1);
  pthread_mutex_lock(&env->mutex);
  ++env->jobs;
  pthread_mutex_unlock(&env->mutex);

  pthread_mutex_lock(&mutex);
  const bool taken = sleeping > waiting || StartThread();
  if (taken) {
    job->next = NULL;
    if (last != NULL) {
      last->next = job;
    } else {
      first = job;
    }
    last = job;
    ++waiting;
    pthread_cond_signal(&wanted);
  }
  pthread_mutex_unlock(&mutex);
  if (!taken) {
    job->status = HGROS_NO_MEMORY;
    job->sentence = strdup("The system has no thread for a call that waits.");
    EndJob(job);
  }
  return promise;
}

void JobEnded(Job* job, hgros_status status) {
  job->status = status;
  if (status != HGROS_OK) job->sentence = strdup(hgros_last_error());
}
