#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "hgros/transport/acting_thread.hpp"

namespace hgros {

/// Allows calls into the user's object until the gate is closed. Closing waits for the calls inside.
///
/// Thread safety: thread-safe.
/// Invariants: after Close() has returned, no thread except the closing one is inside, and none can enter. A thread
/// that closes from within its own call does not wait for itself (see ActingThread).
class CallGate {
 public:
  /// False once closed. Every true is followed by one Leave() on the same thread.
  [[nodiscard]] bool Enter() {
    const std::scoped_lock lock(mutex_);
    if (closed_) return false;
    inside_.push_back(std::this_thread::get_id());
    return true;
  }

  void Leave() {
    const std::scoped_lock lock(mutex_);
    const auto self = std::this_thread::get_id();
    for (auto it = inside_.rbegin(); it != inside_.rend(); ++it) {
      if (*it == self) {
        inside_.erase(std::next(it).base());
        break;
      }
    }
    if (closed_) left_.notify_all();
  }

  void Close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    const auto self = ActingThread::Id();
    left_.wait(lock, [&] {
      for (const auto id : inside_) {
        if (id != self) return false;
      }
      return true;
    });
  }

  /// Runs `call` inside, if the gate is open.
  template <typename Call>
  bool Through(Call&& call) {
    if (!Enter()) return false;
    const Inside inside{*this};
    call();
    return true;
  }

 private:
  struct Inside {
    CallGate& gate;
    ~Inside() { gate.Leave(); }  // Also after an exception.
  };

  std::mutex mutex_;
  std::condition_variable left_;
  std::vector<std::thread::id> inside_;
  bool closed_ = false;
};

}  // namespace hgros
