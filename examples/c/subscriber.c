/* Shows greetings until Ctrl-C. Waits for messages and signals in one loop, without a callback.

     subscriber [CONFIGURATION.yaml] */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <hgros/hgros.h>

#include "greeting.h"

static int signals[2];
static void End(int signal) {
  (void)signal;
  if (write(signals[1], "", 1) < 0) _exit(1);
}

static void Require(hgros_status status) {
  if (status == HGROS_OK) return;
  fprintf(stderr, "subscriber: %s\n", hgros_last_error());
  exit(1);
}

int main(int count, char** arguments) {
  hgros_session* session = NULL;
  hgros_schema* schema = NULL;
  hgros_subscription* queue = NULL;
  hgros_subscribe_options options = {0};
  if (pipe(signals) != 0) return 1;
  (void)signal(SIGINT, End);
  (void)signal(SIGTERM, End);
  if (count > 1) {
    const char* const files[] = {arguments[1]};
    Require(hgros_session_open_files(files, 1, NULL, &session));
  } else {
    Require(hgros_session_open(NULL, NULL, &session));
  }
  Require(hgros_schema_known("foxglove.Log", &schema));
  options.size = sizeof options;
  options.schema = schema; /* Messages of another type are counted and reported, not delivered. */
  Require(hgros_subscribe_queue(session, "greetings", &options, &queue));
  for (;;) {
    struct pollfd waits[] = {{0, POLLIN, 0}, {0, POLLIN, 0}};
    hgros_message* message = NULL;
    waits[0].fd = signals[0];
    waits[1].fd = hgros_queue_descriptor(queue);
    if (poll(waits, 2, -1) < 0 && errno != EINTR) return 1;
    if (waits[0].revents != 0) break;
    const hgros_status taken = hgros_queue_take(queue, 0, &message);
    if (taken == HGROS_OK) {
      size_t size = 0;
      size_t length = 0;
      const unsigned char* const bytes = hgros_message_data(message, &size);
      const char* const text = ReadGreeting(bytes, size, &length);
      printf("%.*s\n", (int)length, text);
      hgros_message_free(message);
    } else if (taken != HGROS_TIMED_OUT) {
      Require(taken); /* Otherwise the descriptor of a queue that has ended would stay readable. */
    }
  }
  hgros_subscription_close(queue);
  hgros_schema_free(schema);
  hgros_session_close(session);
  return 0;
}
