/* Serves "add": two numbers in, their sum out. Then calls it, as any other session could.

     service */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hgros/hgros.h>

struct Numbers {
  int64_t left;
  int64_t right;
};

static void Require(hgros_status status) {
  if (status == HGROS_OK) return;
  fprintf(stderr, "service: %s\n", hgros_last_error());
  exit(1);
}

static void Add(void* user, const hgros_message* request, hgros_reply* reply) {
  struct Numbers numbers;
  size_t size = 0;
  const void* const bytes = hgros_message_data(request, &size);
  (void)user;
  if (size != sizeof numbers) {
    (void)hgros_reply_fail(reply, "The request must have two numbers of 64 bits.");
    return;
  }
  memcpy(&numbers, bytes, size);
  const int64_t sum = numbers.left + numbers.right;
  (void)hgros_reply_set(reply, &sum, sizeof sum);
}

int main(void) {
  hgros_session* session = NULL;
  hgros_schema* numbers = NULL;
  hgros_schema* number = NULL;
  hgros_service* service = NULL;
  hgros_message* reply = NULL;
  const struct Numbers request = {2, 40};
  Require(hgros_session_open(NULL, NULL, &session));
  Require(hgros_schema_create("example/Numbers", HGROS_ENCODING_PLAIN, 0, NULL, 0, &numbers));
  Require(hgros_schema_create("example/Number", HGROS_ENCODING_PLAIN, 0, NULL, 0, &number));
  Require(hgros_serve(session, "add", numbers, number, NULL, Add, NULL, NULL, &service));

  Require(hgros_call(session, "add", numbers, &request, sizeof request, number, INT64_C(1000000000), &reply));
  int64_t sum = 0;
  size_t size = 0;
  const void* const bytes = hgros_message_data(reply, &size);
  if (size == sizeof sum) memcpy(&sum, bytes, size);
  printf("%ld + %ld = %ld\n", (long)request.left, (long)request.right, (long)sum);

  hgros_message_free(reply);
  hgros_service_close(service);
  hgros_schema_free(numbers);
  hgros_schema_free(number);
  hgros_session_close(session);
  return 0;
}
