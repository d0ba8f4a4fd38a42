#include <stdlib.h>
#include <string.h>

#include "addon.h"
#include "value.h"

static void ClosePublisher(void* publisher) { hgros_publisher_close(publisher); }

// openPublisher(session, channel, schema, latched)
static napi_value OpenPublisher(napi_env napi, napi_callback_info info) {
  napi_value arguments[4];
  Part* part = NULL;
  hgros_publisher* publisher = NULL;
  hgros_publish_options options = {.size = sizeof options};
  Arguments(napi, info, 4, arguments);
  Part* const session = OpenPartOf(napi, arguments[0], "The session is closed.");
  if (session == NULL) return NULL;
  options.latched = (uint64_t)NumberOf(napi, arguments[3]);
  char* const channel = TextOf(napi, arguments[1]);
  const napi_value value = NewPart(session->env, session, ClosePublisher, NULL, &part);
  const hgros_status status =
      hgros_publisher_open(session->handle, channel, SchemaOf(napi, arguments[2]), &options, &publisher);
  free(channel);
  return Opened(part, publisher, status, value);
}

static Part* PublisherIn(napi_env napi, napi_value value) {
  return OpenPartOf(napi, value, "The publisher is closed.");
}

// publish(publisher, buffer, patient): if patient, false says that a lossless subscriber has no room.
static napi_value Publish(napi_env napi, napi_callback_info info) {
  napi_value arguments[3];
  size_t size = 0;
  Arguments(napi, info, 3, arguments);
  Part* const publisher = PublisherIn(napi, arguments[0]);
  if (publisher == NULL) return NULL;
  const void* const data = BytesOf(napi, arguments[1], &size);
  const hgros_status status = hgros_publish(publisher->handle, data, size);
  if (status == HGROS_FULL && TruthOf(napi, arguments[2])) return Truth(napi, false);
  return status == HGROS_OK ? Truth(napi, true) : Checked(napi, status);
}

// Memory to fill. JavaScript's handle, each view of the memory, and a job have a reference.
typedef struct {
  hgros_loan* handle;  // NULL: given back.
  size_t refs;
} Loan;

static void ReleaseLoan(Loan* loan) {
  if (--loan->refs > 0) return;
  hgros_loan_free(loan->handle);
  free(loan);
}

static void ForgetLoan(napi_env napi, void* loan, void* nothing) {
  (void)napi;
  (void)nothing;
  ReleaseLoan(loan);
}

static void ForgetView(napi_env napi, void* data, void* loan) {
  (void)napi;
  (void)data;
  ReleaseLoan(loan);
}

static Loan* LoanOf(napi_env napi, napi_value value) {
  void* loan = NULL;
  napi_get_value_external(napi, value, &loan);
  return loan;
}

// openLoan(publisher, size)
static napi_value OpenLoan(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  napi_value value = NULL;
  hgros_loan* handle = NULL;
  Arguments(napi, info, 2, arguments);
  Part* const publisher = PublisherIn(napi, arguments[0]);
  if (publisher == NULL) return NULL;
  const hgros_status status = hgros_loan_open(publisher->handle, (size_t)NumberOf(napi, arguments[1]), &handle);
  if (status != HGROS_OK) return Checked(napi, status);
  Loan* const loan = malloc(sizeof *loan);
  loan->handle = handle;
  loan->refs = 1;
  napi_create_external(napi, loan, ForgetLoan, NULL, &value);
  return value;
}

// viewLoan(loan): a Buffer over its memory; undefined once it is published.
static napi_value ViewLoan(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  napi_value buffer = NULL;
  size_t size = 0;
  Arguments(napi, info, 1, &argument);
  Loan* const loan = LoanOf(napi, argument);
  void* const data = hgros_loan_data(loan->handle, &size);
  if (data == NULL) return Undefined(napi);
  if (napi_create_external_buffer(napi, size, data, ForgetView, loan, &buffer) != napi_ok) {
    return Throw(napi, HGROS_ERROR, "This JavaScript engine cannot show memory of others: publish bytes instead.");
  }
  ++loan->refs;
  return buffer;
}

// closeLoan(loan): gives its memory back now. Its views are detached before, and no job uses it.
static napi_value CloseLoan(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  Loan* const loan = LoanOf(napi, argument);
  hgros_loan_free(loan->handle);
  loan->handle = NULL;
  return Undefined(napi);
}

typedef struct {
  Job job;
  void* data;
  size_t size;
  Loan* loan;  // Instead of the data.
  int64_t timeout_ns;
} PublishJob;

static void WorkPublish(Job* job) {
  PublishJob* const publish = (PublishJob*)job;
  if (publish->loan != NULL) {
    JobEnded(job, hgros_loan_publish(publish->loan->handle, publish->timeout_ns));
  } else {
    JobEnded(job, hgros_publish_wait(job->part->handle, publish->data, publish->size, publish->timeout_ns));
  }
}

static void FreePublish(Job* job) {
  PublishJob* const publish = (PublishJob*)job;
  if (publish->loan != NULL) ReleaseLoan(publish->loan);
  free(publish->data);
  free(job);
}

static PublishJob* NewPublishJob(napi_env napi, napi_value timeout) {
  PublishJob* const job = calloc(1, sizeof *job);
  job->job.work = WorkPublish;
  job->job.free = FreePublish;
  job->timeout_ns = TimeoutOf(napi, timeout);
  return job;
}

// publishWait(publisher, buffer, timeout): a promise. The bytes are copied before this returns.
static napi_value PublishWait(napi_env napi, napi_callback_info info) {
  napi_value arguments[3];
  Arguments(napi, info, 3, arguments);
  Part* const publisher = PublisherIn(napi, arguments[0]);
  if (publisher == NULL) return NULL;
  PublishJob* const job = NewPublishJob(napi, arguments[2]);
  const void* const data = BytesOf(napi, arguments[1], &job->size);
  job->data = malloc(job->size + 1);
  memcpy(job->data, data, job->size);
  return StartJob(&job->job, publisher);
}

// publishLoan(publisher, loan). Its views are detached before.
static napi_value PublishLoan(napi_env napi, napi_callback_info info) {
  napi_value arguments[2];
  Arguments(napi, info, 2, arguments);
  if (PublisherIn(napi, arguments[0]) == NULL) return NULL;
  return Checked(napi, hgros_loan_publish(LoanOf(napi, arguments[1])->handle, 0));
}

// publishLoanWait(publisher, loan, timeout): a promise. Its views are detached before.
static napi_value PublishLoanWait(napi_env napi, napi_callback_info info) {
  napi_value arguments[3];
  Arguments(napi, info, 3, arguments);
  Part* const publisher = PublisherIn(napi, arguments[0]);
  if (publisher == NULL) return NULL;
  PublishJob* const job = NewPublishJob(napi, arguments[2]);
  job->loan = LoanOf(napi, arguments[1]);
  ++job->loan->refs;
  return StartJob(&job->job, publisher);
}

// closePublisher(publisher)
static napi_value ClosePublisherNow(napi_env napi, napi_callback_info info) {
  napi_value argument = NULL;
  Arguments(napi, info, 1, &argument);
  ClosePart(PartOf(napi, argument));
  return Undefined(napi);
}

void DefinePublishing(napi_env napi, napi_value exports) {
  Define(napi, exports, "openPublisher", OpenPublisher);
  Define(napi, exports, "publish", Publish);
  Define(napi, exports, "publishWait", PublishWait);
  Define(napi, exports, "openLoan", OpenLoan);
  Define(napi, exports, "viewLoan", ViewLoan);
  Define(napi, exports, "closeLoan", CloseLoan);
  Define(napi, exports, "publishLoan", PublishLoan);
  Define(napi, exports, "publishLoanWait", PublishLoanWait);
  Define(napi, exports, "closePublisher", ClosePublisherNow);
}
