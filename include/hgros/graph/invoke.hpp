#pragma once

namespace hgros {

/// How many callbacks of one subscription may run at the same time.
enum class Invoke {
  kSerial,      ///< One at a time; each publisher's messages in the order in which it sent them.
  kConcurrent,  ///< Any number at once, in no order; the callback must be thread-safe.
};

}  // namespace hgros
