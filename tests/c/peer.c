/* The other process in processes_test.cpp, in C99.

     peer take CHANNEL COUNT ROOM
         takes COUNT messages through a lossless queue with ROOM, a while apart, and prints them

     peer hold CHANNEL
         subscribes losslessly with room for one message and takes none

     peer serve NAME
         serves NAME, the request in upper case, until it is killed
*/
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hgros/hgros.h>

static const int64_t kPatience = INT64_C(45000000000);

static void Require(hgros_status status) {
  if (status == HGROS_OK) return;
  fprintf(stderr, "peer: %s: %s\n", hgros_status_name(status), hgros_last_error());
  exit(1);
}

static void Say(const char* text) {
  puts(text);
  fflush(stdout);
}

static hgros_subscription* Queue(hgros_session* session, const char* channel, uint64_t room) {
  hgros_subscribe_options options = {0};
  hgros_subscription* queue = NULL;
  options.size = sizeof options;
  options.keep_all = room;
  Require(hgros_subscribe_queue(session, channel, &options, &queue));
  return queue;
}

static void Answer(void* user, const hgros_message* request, hgros_reply* reply) {
  size_t size = 0;
  const char* const text = hgros_message_data(request, &size);
  char* const upper = malloc(size + 1);
  (void)user;
  for (size_t i = 0; i < size; ++i) upper[i] = (char)toupper((unsigned char)text[i]);
  (void)hgros_reply_set(reply, upper, size);
  free(upper);
}

int main(int count, char** arguments) {
  hgros_session* session = NULL;
  hgros_message* message = NULL;
  size_t size = 0;
  if (count < 3) return 2;
  Require(hgros_session_open("data_graph: {threads: 1}", NULL, &session));
  if (strcmp(arguments[1], "take") == 0 && count == 5) {
    hgros_subscription* const queue = Queue(session, arguments[2], strtoul(arguments[4], NULL, 10));
    Say("ready");
    for (long left = strtol(arguments[3], NULL, 10); left > 0; --left) {
      Require(hgros_session_sleep_until(session, hgros_session_now(session) + 1000000));
      Require(hgros_queue_take(queue, kPatience, &message));
      const char* const text = hgros_message_data(message, &size);
      printf("%.*s\n", (int)size, text);
      fflush(stdout);
      hgros_message_free(message);
    }
    hgros_subscription_close(queue);
  } else if (strcmp(arguments[1], "hold") == 0) {
    hgros_subscription* const queue = Queue(session, arguments[2], 1);
    Say("ready");
    Require(hgros_session_sleep_until(session, INT64_MAX));
    hgros_subscription_close(queue);
  } else if (strcmp(arguments[1], "serve") == 0) {
    hgros_schema* text = NULL;
    hgros_service* service = NULL;
    Require(hgros_schema_create("text", HGROS_ENCODING_CUSTOM, 0, NULL, 0, &text));
    Require(hgros_serve(session, arguments[2], text, text, NULL, Answer, NULL, NULL, &service));
    Say("ready");
    Require(hgros_session_sleep_until(session, INT64_MAX));
    hgros_service_close(service);
    hgros_schema_free(text);
  } else {
    return 2;
  }
  hgros_session_close(session);
  return 0;
}
