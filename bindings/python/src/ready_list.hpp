#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "of_process.hpp"

namespace hgros {
class Session;
}

namespace hgros::python {

class SessionHandle;

/// Which inboxes have something for Python, and an eventfd by which a thread or an event loop waits for that.
///
/// If it belongs to a session, the thread in Wait() receives that session's messages itself, where that is possible
/// (Session::ReceiveHere). So no thread of the library has to be woken before it.
///
/// Thread safety: all functions. No thread that calls Add() or Wake() takes the GIL. In a forked child these two do
/// nothing, and Take() and Wait() throw Error.
class ReadyList : public OfProcess {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// `session` may be null.
  explicit ReadyList(const std::shared_ptr<SessionHandle>& session = nullptr);
  ReadyList(const ReadyList&) = delete;
  ReadyList& operator=(const ReadyList&) = delete;
  ~ReadyList();

  void Add(int key);
  /// Lets one Wait() return without a key, also the next one.
  void Wake();
  /// From here on each Wait() returns at once, also those that wait now, and the descriptor is readable.
  void End();
  /// The keys that were added since the last call, in their order; never waits.
  [[nodiscard]] std::vector<int> Take();
  /// As Take(), but waits until there is something, Wake() was called, `timeout_s` has passed (negative: never) or
  /// Python has a signal. Called with the GIL, which it releases while it waits.
  /// Errors: throws what a signal's handler in Python raised, such as KeyboardInterrupt.
  [[nodiscard]] std::vector<int> Wait(double timeout_s);
  /// The same; sets `keys`. False after Wake(), or if the time is over.
  [[nodiscard]] bool WaitUntil(Deadline deadline, std::vector<int>& keys);
  /// `timeout_s` as Wait() takes it.
  [[nodiscard]] static Deadline DeadlineIn(double timeout_s);
  /// Whether Wake() was called, and keys were not taken since then.
  [[nodiscard]] bool woken() const noexcept { return woken_; }

  /// Until Relax(), waits on the main thread save the time to prepare for signals. Nests; called with the GIL.
  static void Prepare();
  static void Relax();

  /// Readable while there is something to take.
  /// For others to wait for. Errors: throws Error if the process can open no more files.
  [[nodiscard]] int HandOutDescriptor();

 private:
  // What was taken.
  struct Rung {
    std::vector<int> keys;
    bool woken = false;
  };

  // Opened when it is needed.
  [[nodiscard]] int DescriptorLocked();
  void RingLocked() noexcept;
  void WriteLocked() noexcept;
  [[nodiscard]] Rung TakeLocked() noexcept;
  // Waits without the descriptor, and without the GIL. False if that is impossible. Sets `rung` if it has.
  [[nodiscard]] bool ReceiveUntil(Deadline deadline, std::optional<Rung>& rung);
  // Waits for the descriptor, and that of signals, without the GIL. False if the time is over.
  [[nodiscard]] bool Poll(int signals, Deadline deadline, std::optional<Rung>& rung);

  const std::weak_ptr<SessionHandle> session_;
  std::mutex mutex_;
  std::vector<int> keys_;
  bool rung_ = false;
  std::atomic<bool> woken_{false};  // By Wake(), since keys were taken.
  bool ended_ = false;
  bool written_ = false;                // To the descriptor.
  int polling_ = 0;                     // Threads that wait for the descriptor in Wait().
  const Session* receiving_ = nullptr;  // A thread is in Session::ReceiveHere() for this list.
  std::thread::id receiver_;
  bool handed_out_ = false;  // So others may wait for it.
  int descriptor_ = -1;
};

}  // namespace hgros::python
