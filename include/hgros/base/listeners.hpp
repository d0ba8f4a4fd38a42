#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace hgros {

/// Keeps a callback registered; move-only. What it is registered with may end before it.
///
/// Lifetime: destroying it stops new calls and waits for the one in flight, unless it is destroyed by that call.
class [[nodiscard]] Listening {
 public:
  Listening() = default;
  /// For whoever keeps the callback: `leave` is called once.
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

/// One callback that may be taken away while others call it.
///
/// Thread safety: all of it. Calls do not overlap, but a callback may call itself.
template <class... Arguments>
class GuardedCallback {
 public:
  explicit GuardedCallback(std::function<void(Arguments...)> callback) : callback_(std::move(callback)) {}

  void Call(Arguments... arguments) {
    const std::scoped_lock lock(calling_);
    if (!closed_) callback_(arguments...);
  }
  /// No call begins any more, and none is under way when this returns but one of this same thread.
  void Close() {
    const std::scoped_lock lock(calling_);
    closed_ = true;
  }

 private:
  std::recursive_mutex calling_;
  bool closed_ = false;
  const std::function<void(Arguments...)> callback_;
};

/// A list of callbacks that are told of events, in the order in which they came.
///
/// Thread safety: all of it. Callbacks run on the thread that tells, without a lock that others need.
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

  void Tell(const Event& event) const {
    std::vector<std::shared_ptr<Place>> places;
    {
      const std::scoped_lock lock(list_->mutex);
      places = list_->places;
    }
    for (const std::shared_ptr<Place>& place : places) place->Call(event);
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
