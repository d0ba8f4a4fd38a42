#pragma once

#include "hgros/base/log.hpp"

namespace hgros {

// The end of a session's log. Not the destructor of Log: nodes may keep the log longer than its sink may be called.
//
// Thread safety: all functions.
class LogEnding {
 public:
  explicit LogEnding(Log& log) : log_(log) {}

  // Says how many lines were held back, for each key.
  void WriteHeldBack() { log_.WriteHeldBack(); }

 private:
  Log& log_;
};

}  // namespace hgros
