#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "c/calling.hpp"
#include "hgros/base/fork_guard.hpp"

namespace hgros::c {

// Something that must end before its session, but whose handle may outlive it.
class Dependent {
 public:
  virtual ~Dependent() = default;
  // Refuses further use and wakes the uses that wait. Does not wait.
  virtual void Stop() noexcept = 0;
  // Refuses further use, waits for the uses that run, and destroys the object.
  virtual void End() = 0;
  // The session was left inside a callback: the object stays until the process ends, as the session does.
  virtual void Leave() noexcept = 0;
};

// An object of a session in a handle. Functions of it that wait get `stop`, or the object has EndWaits(), which does
// not wait.
//
// Thread safety: all functions. A use may use it again, for example in a callback.
template <class T>
class Held final : public Dependent {
 public:
  explicit Held(std::unique_ptr<T> object) : object_(std::move(object)) {}
  ~Held() override {
    if (left_ || fork_.IsChild())
      LeaveToParent(std::shared_ptr<const T>(std::move(object_)));  // Kept, as the session is.
  }

  template <class F>
  hgros_status Use(F&& use) {
    T* object = nullptr;
    if (!fork_.IsChild()) {
      const std::scoped_lock lock(mutex_);
      if (!ended_) object = object_.get();
      if (object != nullptr) ++uses_;
    }
    if (object == nullptr) {
      return Fail(HGROS_CLOSED,
                  fork_.IsChild() ? kOfParent : "The session has ended, or this handle was closed before.");
    }
    const auto leave = [this](T*) {
      const std::scoped_lock lock(mutex_);
      if (--uses_ == 0) unused_.notify_all();
    };
    const std::unique_ptr<T, decltype(leave)> used(object, leave);
    return use(*object);
  }
  [[nodiscard]] std::stop_token stop() const noexcept { return stop_.get_token(); }

  void Stop() noexcept override {
    stop_.request_stop();
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    if constexpr (requires { object_->EndWaits(); }) {
      if (object_) object_->EndWaits();
    }
  }
  void End() override {
    if (fork_.IsChild()) return;
    Stop();
    const auto here = std::this_thread::get_id();
    std::unique_lock lock(mutex_);
    unused_.wait(lock, [&] { return uses_ == 0 && (!destroyer_ || destroyer_ == here); });
    if (left_ || !object_) return;
    std::unique_ptr<T> ended = std::move(object_);
    destroyer_ = here;
    lock.unlock();
    ended.reset();  // Without the lock, because its callbacks may use the handle.
    lock.lock();
    destroyer_.reset();
    unused_.notify_all();
  }
  void Leave() noexcept override {
    Stop();
    const std::scoped_lock lock(mutex_);
    left_ = true;
  }

 private:
  const ForkGuard fork_;
  std::stop_source stop_;
  std::mutex mutex_;
  std::condition_variable unused_;
  std::unique_ptr<T> object_;
  int uses_ = 0;
  std::optional<std::thread::id> destroyer_;  // While it destroys the object. What that calls may end it again.
  bool ended_ = false;
  bool left_ = false;
};

}  // namespace hgros::c
