/* Publishes a greeting ten times a second until Ctrl-C. `hgros echo greetings` and subscriber show them.

     publisher [CONFIGURATION.yaml] */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include <hgros/hgros.h>

#include "greeting.h"

static volatile sig_atomic_t ended = 0;
static void End(int signal) {
  (void)signal;
  ended = 1;
}

static void Require(hgros_status status) {
  if (status == HGROS_OK) return;
  fprintf(stderr, "publisher: %s\n", hgros_last_error());
  exit(1);
}

int main(int count, char** arguments) {
  hgros_session* session = NULL;
  hgros_schema* schema = NULL;
  hgros_publisher* publisher = NULL;
  (void)signal(SIGINT, End);
  (void)signal(SIGTERM, End);
  if (count > 1) {
    const char* const files[] = {arguments[1]};
    Require(hgros_session_open_files(files, 1, NULL, &session));
  } else {
    Require(hgros_session_open(NULL, NULL, &session));
  }
  Require(hgros_schema_known("foxglove.Log", &schema));
  Require(hgros_publisher_open(session, "greetings", schema, NULL, &publisher));
  for (int number = 1; !ended; ++number) {
    char text[64];
    unsigned char message[kMostGreeting];
    (void)snprintf(text, sizeof text, "Hello number %d", number);
    const size_t size = WriteGreeting(text, message);
    Require(hgros_publish(publisher, message, size));
    Require(hgros_session_sleep_until(session, hgros_session_now(session) + 100000000));
  }
  hgros_publisher_close(publisher);
  hgros_schema_free(schema);
  hgros_session_close(session);
  return 0;
}
