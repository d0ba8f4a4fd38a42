#pragma once

#include <node_api.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <uv.h>

#include "hgros/hgros.h"

// The addon carries calls from JavaScript to the library and what the library says back. The checks of what a program
// gives, and all that is more than a call, are in lib/.
//
// Threads: everything runs on the thread of JavaScript, except what says otherwise.

typedef struct Env Env;
typedef struct Part Part;
typedef struct Request Request;

/// Something that a thread of the library has for JavaScript. `run` is called once and frees it. It is called by any
/// thread with `env` NULL if JavaScript has ended.
typedef struct Arrival {
  struct Arrival* next;
  void (*run)(Env* env, struct Arrival* arrival);
} Arrival;

/// One instance of the addon: the main program's, or that of a worker thread.
struct Env {
  Env* next;
  napi_env napi;
  napi_ref error_class;
  napi_ref scratch;  ///< A BigInt64Array, whose memory is `numbers`: what take() says about the message it returns.
  int64_t* numbers;
  napi_async_context context;
  napi_async_cleanup_hook_handle cleanup;
  uv_async_t bell;    ///< Rung for each arrival. Referenced while `awake` is not 0.
  size_t awake;       ///< What keeps the program from ending: jobs, calls, services, watches.
  size_t uv_handles;  ///< Those not yet closed.

  pthread_mutex_t mutex;   ///< For all below, and where Part and Request say so. Held during no call of the library.
  pthread_cond_t changed;  ///< A job has ended.
  bool over;               ///< Nothing more reaches JavaScript.
  Arrival* first;
  Arrival* last;
  size_t jobs;  ///< Running on other threads.
  size_t refs;  ///< The instance's own, and those of parts.
  Request* requests;
  Part* parts;  ///< The open ones.
};

/// An object of the library that JavaScript holds: a session, or a part of one. Open until it or its session is closed.
struct Part {
  Env* env;
  Part* session;  ///< NULL for a session.
  void* handle;
  void (*close)(void* handle);
  napi_ref callback;     ///< NULL: none.
  uv_poll_t* poll;       ///< Of a queue.
  hgros_schema* schema;  ///< Of a queue: the type of the last message.
  bool keeps_awake;

  bool closed;  ///< These are protected by the mutex; JavaScript's thread is the only one that writes `closed`.
  size_t jobs;  ///< That use it, or parts of it.
  size_t refs;  ///< JavaScript's, one for being open, and those of jobs.
  Part* next;
};

/// A call of the library that may wait, on a thread of its own; it settles a promise.
typedef struct Job {
  Arrival arrival;
  struct Job* next;
  Env* env;
  Part* part;
  napi_deferred deferred;
  void (*work)(struct Job* job);                         ///< On another thread. Sets `status`.
  napi_value (*result)(napi_env napi, struct Job* job);  ///< NULL: undefined.
  void (*free)(struct Job* job);                         ///< Frees what `work` needed and made, then the job.
  hgros_status status;
  char* sentence;
} Job;

/// A request that a thread of the library waits for, on whose stack it is. Protected by the mutex.
struct Request {
  Request* next;
  uint64_t number;
  Part* service;
  pthread_cond_t answered;
  bool done;
  char* failure;  ///< The handler's sentence, or NULL.
  void* data;
  size_t size;
};

// addon.c
Env* EnvOf(napi_env napi);
/// Changes by how much the program is kept from ending.
void KeepAwake(Env* env, int change);
/// Any thread.
void ReleaseEnv(Env* env);
/// A uv handle of this addon has been closed.
void UvHandleClosed(Env* env);

// inbox.c
void OpenInbox(Env* env, uv_loop_t* loop);
/// Any thread.
void Post(Env* env, Arrival* arrival);
/// Drops what has not been delivered. The environment is over.
void DropArrivals(Env* env);
/// Calls a function of JavaScript, outside any other. What it throws ends the program as any uncaught error does.
void CallBack(Env* env, napi_ref function, size_t count, const napi_value* arguments);

// part.c
/// An open part, and its value in JavaScript. `callback` may be NULL.
napi_value NewPart(Env* env, Part* session, void (*close)(void*), napi_value callback, Part** part);
/// It has been made by the library; or, if `status` says that it was not, it is forgotten and the error thrown.
napi_value Opened(Part* part, void* handle, hgros_status status, napi_value value);
/// Lets the loop watch a descriptor of the part until it is closed.
bool AddPoll(Part* part, uv_loop_t* loop, int descriptor);
Part* PartOf(napi_env napi, napi_value value);
/// Throws HGROS_CLOSED and returns NULL if it is closed.
Part* OpenPartOf(napi_env napi, napi_value value, const char* what);
void ClosePart(Part* part);
/// Closes on another thread, a session with all its parts. The value is a promise.
napi_value ClosePartLater(Part* part);
/// Any thread. Keeps the memory of the part, not its handle.
void RetainPart(Part* part);
void ReleasePart(Part* part);
/// A job uses the handle until LeavePart().
void UsePart(Part* part);
/// Any thread. The last use of a closed part closes its handle.
void LeavePart(Part* part);
/// Closes all sessions and parts, and waits for it. Nothing reaches JavaScript any more.
void CloseEverything(Env* env, bool loop_runs);

// job.c
/// Starts a job on a part, which is used meanwhile. The value is its promise.
napi_value StartJob(Job* job, Part* part);
/// For Job.work: takes the sentence of a failure.
void JobEnded(Job* job, hgros_status status);

// services.c
/// Any thread that has the mutex: fails the requests of a session, or of all if it is NULL.
void FailRequests(Env* env, const Part* session, const char* sentence);

// message.c
/// The bytes of a message, which is freed with them: a copy if they are few, otherwise the memory where they are.
napi_value BufferOf(napi_env napi, hgros_message* message);
const hgros_schema* SchemaOf(napi_env napi, napi_value value);
napi_value NewSchema(napi_env napi, hgros_schema* schema);

// Each defines the functions of one subject in `exports`.
void DefineMessages(napi_env napi, napi_value exports);
void DefineObservation(napi_env napi, napi_value exports);
void DefineParams(napi_env napi, napi_value exports);
void DefinePublishing(napi_env napi, napi_value exports);
void DefineServices(napi_env napi, napi_value exports);
void DefineSessions(napi_env napi, napi_value exports);
void DefineSubscribing(napi_env napi, napi_value exports);
void DefineTransforms(napi_env napi, napi_value exports);
