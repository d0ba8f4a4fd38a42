#pragma once

#include <cxxabi.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace hgros {

/// Keeps a callback registered; move-only. The object it is registered with may end first.
///
/// Lifetime: destroying it stops new calls, waits for the one in flight and destroys the callback's captures, unless it
/// is destroyed by that call: then they are destroyed after it.
class [[nodiscard]] Listening {
 public:
  Listening() = default;
  /// For the object that keeps the callback: `leave` is called once.
  explicit Listening(std::function<void()> leave) : leave_(std::move(leave)) {}
  Listening(Listening&& other) noexcept : leave_(std::exchange(other.leave_, nullptr)) {}
  Listening& operator=(Listening&& other) noexcept {
    if (this != &other) {
      Reset();
      leave_ = std::exchange(other.leave_, nullptr);
    }
    return *this;
  }
  ~Listening() { Reset(); }

  void Reset() {
    if (const std::function<void()> leave = std::exchange(leave_, nullptr)) leave();
  }

 private:
  std::function<void()> leave_;
};

/// A callback that can be removed while other threads call it.
///
/// Thread safety: all functions. Calls do not overlap, but a callback may call itself.
template <class... Arguments>
class GuardedCallback {
 public:
  explicit GuardedCallback(std::function<void(Arguments...)> callback) : callback_(std::move(callback)) {}

  void Call(Arguments... arguments) {
    Callback ended;  // Destroyed after the lock.
    const std::scoped_lock lock(calling_);
    if (closed_) return;
    ++depth_;
    const auto leave = [&](GuardedCallback* of) {
      if (--of->depth_ == 0 && of->closed_) ended = std::exchange(of->callback_, nullptr);
    };
    const std::unique_ptr<GuardedCallback, decltype(leave)> left(this, leave);
    callback_(arguments...);
  }
  /// No call starts after this returns, and none is running except on this thread.
  void Close() {
    Callback ended;
    const std::scoped_lock lock(calling_);
    closed_ = true;
    if (depth_ == 0) ended = std::exchange(callback_, nullptr);
  }

 private:
  using Callback = std::function<void(Arguments...)>;

  std::recursive_mutex calling_;
  int depth_ = 0;
  bool closed_ = false;
  Callback callback_;
};

/// Callbacks for events, called in the order in which they were added.
///
/// Thread safety: all functions. Callbacks run on the calling thread, without a lock that other threads need.
template <class Event>
class Listeners {
 public:
  using Callback = std::function<void(const Event&)>;

  Listening Add(Callback callback) {
    auto place = std::make_shared<Place>(std::move(callback));
    {
      const std::scoped_lock lock(list_->mutex);
      list_->places.push_back(place);
    }
    return Listening([list = std::weak_ptr(list_), place = std::move(place)] {
      if (const auto there = list.lock()) {
        const std::scoped_lock lock(there->mutex);
        std::erase(there->places, place);
      }
      place->Close();
    });
  }

  /// Calls all, also if one throws; then rethrows what the first of these threw.
  void Tell(const Event& event) const {
    std::vector<std::shared_ptr<Place>> places;
    {
      const std::scoped_lock lock(list_->mutex);
      places = list_->places;
    }
    std::exception_ptr thrown;
    for (const std::shared_ptr<Place>& place : places) {
      try {
        place->Call(event);
      } catch (const abi::__forced_unwind&) {  // The thread ends.
        throw;
      } catch (...) {
        if (!thrown) thrown = std::current_exception();
      }
    }
    if (thrown) std::rethrow_exception(thrown);
  }

 private:
  using Place = GuardedCallback<const Event&>;
  struct List {
    std::mutex mutex;
    std::vector<std::shared_ptr<Place>> places;
  };

  std::shared_ptr<List> list_ = std::make_shared<List>();
};

}  // namespace hgros
