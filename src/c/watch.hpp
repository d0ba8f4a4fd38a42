#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "c/callbacks.hpp"
#include "hgros/c/observe.h"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/base/listeners.hpp"

namespace hgros::c {

// Keeps a callback registered. One of both is in use.
struct Watching {
  Subscription subscription;
  Listening listening;
};

// The calls of a watch, shared with its callback.
//
// Thread safety: all functions.
class WatchCalls {
 public:
  // For a callback that is called more than once for one event.
  [[nodiscard]] bool closed() const noexcept { return closed_.load(std::memory_order_acquire); }
  // Runs `call` unless it is closed.
  template <class F>
  void Run(F&& call) {
    {
      const std::scoped_lock lock(mutex_);
      if (closed()) return;
      ++running_;
    }
    const auto leave = [](WatchCalls* of) { of->Leave(); };
    const std::unique_ptr<WatchCalls, decltype(leave)> running(this, leave);
    call();
  }
  // No call comes after it. Waits for the running one, but not inside a callback, for which that one may wait, too.
  void Close(Watching watching) {
    closed_.store(true, std::memory_order_release);
    if (!InCallback::Here()) return;
    const std::scoped_lock lock(mutex_);
    if (running_ > 0) ended_ = std::move(watching);
  }

 private:
  void Leave() noexcept {
    Watching ended;  // Destroyed after the lock.
    const std::scoped_lock lock(mutex_);
    if (--running_ == 0) ended = std::move(ended_);
  }

  std::atomic<bool> closed_{false};
  std::mutex mutex_;
  int running_ = 0;  // guarded by mutex_
  Watching ended_;   // guarded by mutex_: for the running call to destroy
};

}  // namespace hgros::c

struct hgros_watch {
  ~hgros_watch() { calls->Close(std::move(watching)); }

  const std::shared_ptr<hgros::c::WatchCalls> calls = std::make_shared<hgros::c::WatchCalls>();
  hgros::c::Watching watching;
};
