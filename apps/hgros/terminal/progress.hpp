#pragma once

#include <chrono>
#include <string>

namespace hgros::cli {

class Console;
class Pause;

/// A long wait that the user sees: after the first second, and then once a second, Pause shows a line such as
/// "waiting for a reply of ask: 3 of 10 s" on a terminal, and the line goes when this object does. Nothing is shown
/// where standard error is no terminal. There is one object at a time.
///
/// Threading: the thread of the command.
class Progress {
 public:
  /// `what` is visible. `length`: how long the wait can take; 0: not known.
  Progress(Console& console, Pause& pause, std::string what, std::chrono::nanoseconds length = {});
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

 private:
  Console& console_;
  Pause& pause_;
};

}  // namespace hgros::cli
