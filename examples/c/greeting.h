#pragma once

#include <stddef.h>
#include <string.h>

/* The protobuf message foxglove.Log with one field, `message`: its tag, its length, its bytes. For larger types use a
   generator, such as protobuf-c or nanopb. */
enum { kMostText = 127, kMostGreeting = kMostText + 2, kMessageTag = (3 << 3) | 2 };

static inline size_t WriteGreeting(const char* text, unsigned char* to) {
  const size_t length = strlen(text) < kMostText ? strlen(text) : kMostText;
  to[0] = kMessageTag;
  to[1] = (unsigned char)length;
  memcpy(to + 2, text, length);
  return length + 2;
}

/* The text of such a message; `*length` is 0 if it has another form. */
static inline const char* ReadGreeting(const unsigned char* from, size_t size, size_t* length) {
  const int fits = size >= 2 && from[0] == kMessageTag && from[1] <= kMostText && (size_t)from[1] + 2 <= size;
  *length = fits ? from[1] : 0;
  return fits ? (const char*)from + 2 : "";
}
