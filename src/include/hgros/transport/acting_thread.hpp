#pragma once

#include <thread>
#include <utility>

#include "hgros/base/thread_local.hpp"

namespace hgros {

/// While it lives, the calling thread closes channels and transports on behalf of another thread: calls and tasks that
/// run on that thread are not waited for, as if it closed them itself.
class ActingThread {
 public:
  explicit ActingThread(std::thread::id on_behalf_of) noexcept : outer_(std::exchange(self, on_behalf_of)) {}
  ActingThread(const ActingThread&) = delete;
  ActingThread& operator=(const ActingThread&) = delete;
  ~ActingThread() { self = outer_; }

  /// The thread on whose behalf the calling thread acts, usually the calling thread.
  [[nodiscard]] static std::thread::id Id() noexcept {
    return self == std::thread::id() ? std::this_thread::get_id() : self;
  }

 private:
  static inline HGROS_THREAD_LOCAL std::thread::id self;
  const std::thread::id outer_;
};

}  // namespace hgros
