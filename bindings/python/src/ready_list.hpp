#pragma once

#include <mutex>
#include <vector>

#include "of_process.hpp"

namespace hgros::python {

/// Which inboxes have something for Python, and an eventfd by which a thread or an event loop waits for that.
///
/// Thread safety: all functions. No thread that calls Add() or Wake() takes the GIL. In a forked child these two do
/// nothing, and Take() and Wait() throw Error.
class ReadyList : public OfProcess {
 public:
  /// Errors: throws Error if the process can open no more files.
  ReadyList();
  ReadyList(const ReadyList&) = delete;
  ReadyList& operator=(const ReadyList&) = delete;
  ~ReadyList();

  void Add(int key);
  /// Lets one Wait() return without a key, also the next one.
  void Wake();
  /// The keys that were added since the last call, in their order; never waits.
  [[nodiscard]] std::vector<int> Take();
  /// As Take(), but waits until there is something, Wake() was called, `timeout_s` has passed (negative: never) or
  /// Python has a signal. Called with the GIL, which it releases while it waits.
  /// Errors: throws what a signal's handler in Python raised, such as KeyboardInterrupt.
  [[nodiscard]] std::vector<int> Wait(double timeout_s);

  /// Until Relax(), waits on the main thread save the time to prepare for signals. Nests; called with the GIL.
  static void Prepare();
  static void Relax();

  /// Readable while there is something to take.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

 private:
  void RingLocked() noexcept;
  [[nodiscard]] std::vector<int> TakeIfRung(bool& rung);

  std::mutex mutex_;
  std::vector<int> keys_;
  bool rung_ = false;
  int descriptor_;
};

}  // namespace hgros::python
