/* The peer in C99 with POSIX. ../README.md says what each role does. Its messages are written and read by hand: only
   the few fields of foxglove.Log and foxglove.PointCloud that the roles use. */
#define _POSIX_C_SOURCE 200809L

#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <hgros/hgros.h>

enum { kMostText = 200, kMostLine = 512, kMostWords = 3, kRoom = 100 };

static const int64_t kPatience = INT64_C(30000000000);
static const int64_t kSlice = INT64_C(100000000);

static hgros_session* session;
static hgros_schema* log_schema;
static hgros_schema* cloud_schema;
static hgros_schema* pose_schema;

static void Fail(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("peer: ", stderr);
  vfprintf(stderr, format, arguments);
  fputs("\n", stderr);
  va_end(arguments);
  exit(1);
}

static void Require(hgros_status status) {
  if (status != HGROS_OK) Fail("%s: %s", hgros_status_name(status), hgros_last_error());
}

static void Say(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vprintf(format, arguments);
  va_end(arguments);
  puts("");
  fflush(stdout);
}

/* The lines of standard input. */

static char input[kMostLine + 1];
static size_t input_size;
static int input_ended;

/* Whether there is a next line, or the end, within `timeout_ms`; -1: waits without limit. */
static int Waits(int timeout_ms) {
  while (!input_ended && memchr(input, '\n', input_size) == NULL) {
    struct pollfd standard_input = {STDIN_FILENO, POLLIN, 0};
    if (poll(&standard_input, 1, timeout_ms) == 0) return 0;
    const ssize_t count = read(STDIN_FILENO, input + input_size, kMostLine - input_size);
    if (count > 0) input_size += (size_t)count;
    input_ended = count <= 0;
  }
  return 1;
}

/* The next line without its end, or 0. */
static int NextLine(char* line) {
  (void)Waits(-1);
  const char* const end = memchr(input, '\n', input_size);
  if (end == NULL) return 0;
  const size_t size = (size_t)(end - input);
  memcpy(line, input, size);
  line[size] = 0;
  input_size -= size + 1;
  memmove(input, end + 1, input_size);
  return 1;
}

/* foxglove.Log: field 3 is `message`. */

struct Text {
  unsigned char bytes[kMostText + 2];
  size_t size;
};

static struct Text WriteLog(const char* text) {
  struct Text log;
  const size_t size = strlen(text);
  if (size > 127) Fail("The text is too long.");
  log.bytes[0] = 3 << 3 | 2;
  log.bytes[1] = (unsigned char)size;
  memcpy(log.bytes + 2, text, size);
  log.size = size + 2;
  return log;
}

static uint64_t ReadVarint(const unsigned char** at, const unsigned char* end) {
  uint64_t value = 0;
  for (unsigned shift = 0; *at < end && shift < 64; shift += 7) {
    const unsigned char byte = *(*at)++;
    value |= (uint64_t)(byte & 127) << shift;
    if (byte < 128) return value;
  }
  Fail("A number in a message is cut off.");
  return 0;
}

/* The last bytes with this field number; none if there are none. */
static const unsigned char* FindBytes(const hgros_message* message, unsigned field, size_t* size) {
  size_t left = 0;
  const unsigned char* at = hgros_message_data(message, &left);
  const unsigned char* const end = at + left;
  const unsigned char* found = NULL;
  *size = 0;
  while (at < end) {
    const uint64_t tag = ReadVarint(&at, end);
    uint64_t length = 0;
    switch (tag & 7) {
      case 0: (void)ReadVarint(&at, end); break;
      case 1: length = 8; break;
      case 2: length = ReadVarint(&at, end); break;
      case 5: length = 4; break;
      default: Fail("A message has wire type %d.", (int)(tag & 7));
    }
    if (length > (uint64_t)(end - at)) Fail("A field of a message is cut off.");
    if (tag == (field << 3 | 2)) {
      found = at;
      *size = (size_t)length;
    }
    at += length;
  }
  return found;
}

static void ReadLog(const hgros_message* message, char* text) {
  size_t size = 0;
  const unsigned char* const bytes = FindBytes(message, 3, &size);
  if (size > kMostText) Fail("A text has %lu bytes.", (unsigned long)size);
  if (size > 0) memcpy(text, bytes, size);
  text[size] = 0;
}

static unsigned char ByteAt(size_t i) { return (unsigned char)((i * 7 + 3) & 255); }

/* The roles. */

static hgros_publisher* Advertise(const char* channel, const hgros_schema* schema, uint64_t latched) {
  hgros_publish_options options = {0};
  hgros_publisher* publisher = NULL;
  options.size = sizeof options;
  options.latched = latched;
  Require(hgros_publisher_open(session, channel, schema, &options, &publisher));
  return publisher;
}

static hgros_subscription* Queue(const char* channel, const hgros_schema* schema, uint64_t room) {
  hgros_subscribe_options options = {0};
  hgros_subscription* queue = NULL;
  options.size = sizeof options;
  options.schema = schema;
  options.keep_all = room;
  Require(hgros_subscribe_queue(session, channel, &options, &queue));
  return queue;
}

static void Publish(const char* channel, const char* count) {
  hgros_publisher* const publisher = Advertise(channel, log_schema, 0);
  const long most = atol(count);
  long sent = 0;
  Require(hgros_session_wait_for_subscribers(session, channel, 1, kPatience));
  while (sent < most && !Waits(0)) {
    char text[24];
    snprintf(text, sizeof text, "%ld", sent + 1);
    const struct Text log = WriteLog(text);
    const hgros_status status = hgros_publish_wait(publisher, log.bytes, log.size, kSlice);
    if (status == HGROS_TIMED_OUT || status == HGROS_FULL) continue;
    Require(status);
    if (++sent == 1) Say("publishing");
  }
  Say("published %ld", sent);
  (void)Waits(-1);
  hgros_publisher_close(publisher);
}

static void Subscribe(const char* channel, const char* count) {
  hgros_subscription* const queue = Queue(channel, log_schema, kRoom);
  const long most = atol(count);
  int from_one = 0;
  char text[kMostText + 1] = "";
  long received = 0;
  while (received < most && !Waits(0)) {
    hgros_message* message = NULL;
    const hgros_status status = hgros_queue_take(queue, kSlice, &message);
    if (status == HGROS_TIMED_OUT) continue;
    Require(status);
    ReadLog(message, text);
    hgros_message_free(message);
    if (++received == 1) Say("receiving %s", text);
    if (received == 1) from_one = strcmp(text, "1") == 0;
    if (from_one && atol(text) != received) Fail("\"%s\" came, not %ld.", text, received);
  }
  Say("received %ld %s", received, text);
  hgros_subscription_close(queue);
}

static void Latch(const char* channel, const char* text) {
  hgros_publisher* const publisher = Advertise(channel, log_schema, 2);
  const char* const texts[] = {"old", text, "new"};
  for (int i = 0; i < 3; ++i) {
    const struct Text log = WriteLog(texts[i]);
    Require(hgros_publish(publisher, log.bytes, log.size));
  }
  Say("latched");
  (void)Waits(-1);
  hgros_publisher_close(publisher);
}

static void BulkPublish(const char* channel, const char* bytes) {
  hgros_publisher* const publisher = Advertise(channel, cloud_schema, 0);
  const size_t size = strtoul(bytes, NULL, 10);
  /* Field 4 is `point_stride`, a fixed32; field 6 is `data`. */
  unsigned char head[16] = {4 << 3 | 5, 1, 0, 0, 0, 6 << 3 | 2};
  size_t head_size = 6;
  hgros_loan* loan = NULL;
  for (size_t left = size; left > 0 || head_size == 6; left >>= 7) {
    head[head_size++] = (unsigned char)((left & 127) | (left > 127 ? 128 : 0));
  }
  Require(hgros_session_wait_for_subscribers(session, channel, 1, kPatience));
  Require(hgros_loan_open(publisher, head_size + size, &loan));
  unsigned char* const data = hgros_loan_data(loan, NULL);
  memcpy(data, head, head_size);
  for (size_t i = 0; i < size; ++i) data[head_size + i] = ByteAt(i);
  Require(hgros_loan_publish(loan, kPatience));
  hgros_loan_free(loan);
  Say("published %s", bytes);
  (void)Waits(-1);
  hgros_publisher_close(publisher);
}

static void BulkSubscribe(const char* channel, const char* bytes) {
  hgros_subscription* const queue = Queue(channel, cloud_schema, kRoom);
  const size_t expected_size = strtoul(bytes, NULL, 10);
  hgros_message* message = NULL;
  size_t size = 0;
  Say("subscribed");
  Require(hgros_queue_take(queue, kPatience, &message));
  const unsigned char* const data = FindBytes(message, 6, &size);
  if (size != expected_size) Fail("The cloud has %lu bytes.", (unsigned long)size);
  for (size_t i = 0; i < size; ++i) {
    if (data[i] != ByteAt(i)) Fail("The cloud has other bytes.");
  }
  hgros_message_free(message);
  Say("received %s", bytes);
  hgros_subscription_close(queue);
}

static void Answer(void* user, const hgros_message* request, hgros_reply* reply) {
  char text[kMostText + 1];
  char answer[kMostText + 5];
  (void)user;
  ReadLog(request, text);
  if (strcmp(text, "fail") == 0) {
    (void)hgros_reply_fail(reply, "asked to fail");
    return;
  }
  snprintf(answer, sizeof answer, "re: %s", text);
  const struct Text log = WriteLog(answer);
  (void)hgros_reply_set(reply, log.bytes, log.size);
}

static void Serve(const char* name, const char* unused) {
  hgros_service* service = NULL;
  (void)unused;
  Require(hgros_serve(session, name, log_schema, log_schema, NULL, Answer, NULL, NULL, &service));
  Say("serving");
  (void)Waits(-1);
  hgros_service_close(service);
}

static void Call(const char* name, const char* text) {
  const struct Text log = WriteLog(text);
  const int64_t deadline = hgros_session_now(session) + kPatience;
  hgros_message* reply = NULL;
  char answer[kMostText + 1];
  hgros_status status = HGROS_NO_SERVER;
  while (status == HGROS_NO_SERVER && hgros_session_now(session) < deadline) {
    status = hgros_call(session, name, log_schema, log.bytes, log.size, log_schema, kPatience, &reply);
    if (status == HGROS_NO_SERVER && Waits(10)) Fail("Nobody serves %s.", name);
  }
  if (status != HGROS_OK) {
    Say("failed %s", hgros_last_error());
    return;
  }
  ReadLog(reply, answer);
  hgros_message_free(reply);
  Say("answer %s", answer);
}

static void Misfit(const char* channel, const char* unused) {
  hgros_subscription* const queue = Queue(channel, pose_schema, 0);
  (void)unused;
  Say("subscribed");
  (void)Waits(-1);
  hgros_subscription_close(queue);
}

static void Run(char** words, int count);

static void Talk(const char* unused, const char* unused_too) {
  char line[kMostLine + 1];
  (void)unused;
  (void)unused_too;
  Say("ready");
  while (NextLine(line)) {
    char* words[kMostWords];
    int count = 0;
    for (char* word = strtok(line, " "); word != NULL && count < kMostWords; word = strtok(NULL, " ")) {
      words[count++] = word;
    }
    if (count > 0) Run(words, count);
  }
}

static const struct {
  const char* name;
  void (*run)(const char* first, const char* second);
} kRoles[] = {{"talk", Talk},
              {"publish", Publish},
              {"subscribe", Subscribe},
              {"latch", Latch},
              {"bulk-publish", BulkPublish},
              {"bulk-subscribe", BulkSubscribe},
              {"serve", Serve},
              {"call", Call},
              {"misfit", Misfit}};

static void Run(char** words, int count) {
  for (size_t i = 0; i < sizeof kRoles / sizeof *kRoles; ++i) {
    if (strcmp(words[0], kRoles[i].name) == 0) {
      kRoles[i].run(count > 1 ? words[1] : "", count > 2 ? words[2] : "");
      return;
    }
  }
  Fail("There is no role %s.", words[0]);
}

int main(int count, char** words) {
  if (count < 2) Fail("usage: peer ROLE [ARGUMENT...]");
  Require(hgros_session_open(getenv("HGROS_INTEROP_YAML"), NULL, &session));
  Require(hgros_schema_known("foxglove.Log", &log_schema));
  Require(hgros_schema_known("foxglove.PointCloud", &cloud_schema));
  Require(hgros_schema_known("foxglove.PoseInFrame", &pose_schema));
  Run(words + 1, count - 1);
  hgros_schema_free(log_schema);
  hgros_schema_free(cloud_schema);
  hgros_schema_free(pose_schema);
  hgros_session_close(session);
  return 0;
}
