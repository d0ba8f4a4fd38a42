#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "c/callbacks.hpp"
#include "c/calling.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/c/session.h"
#include "hgros/session/session.hpp"

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

// What the handles of a session share with it. They keep it alive; it does not keep the session.
//
// Thread safety: all functions.
class Life {
 public:
  explicit Life(Session& session) : session_(&session) {}

  // The session has ended, or this is a forked child: the locks here may be held by threads that it does not have.
  [[nodiscard]] bool closed() const noexcept { return closed_.load(std::memory_order_acquire) || fork_.IsChild(); }
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }
  [[nodiscard]] std::stop_token stop() const noexcept { return stop_.get_token(); }
  // Runs `use` with the session, which does not end meanwhile. `use` must not wait.
  template <class F>
  hgros_status Use(F&& use) {
    if (closed()) return Fail(HGROS_CLOSED, kSessionClosed);
    const std::shared_lock lock(mutex_);
    if (session_ == nullptr) return Fail(HGROS_CLOSED, kSessionClosed);
    return use(*session_);
  }
  void Add(const std::shared_ptr<Dependent>& dependent);
  // Wakes all that wait for the session, and refuses its further use. Does not wait.
  void Stop();
  // The session is about to be destroyed. `inside`: in one of its callbacks.
  void End(bool inside);

 private:
  const ForkGuard fork_;
  std::atomic<bool> closed_{false};
  std::stop_source stop_;
  std::shared_mutex mutex_;
  Session* session_;
  std::vector<std::weak_ptr<Dependent>> dependents_;
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
    if (object == nullptr) return Fail(HGROS_CLOSED, "The session has ended, or this handle was closed before.");
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

// Ends an object and destroys its handle. Not inside a callback or the release of its user data, for which the object
// may have to wait.
template <class T, class F>
hgros_status Closing(const Life* life, Held<T>& held, F&& destroy) {
  return Guarded([&] {
    if (InCallback::Of(&held) || (life != nullptr && InCallback::Of(life))) {
      return Fail(HGROS_WOULD_DEADLOCK, "This handle cannot be closed inside a callback. Close it on another thread.");
    }
    const InClose closes;
    held.End();
    destroy();
    return hgros_status{HGROS_OK};
  });
}

}  // namespace hgros::c

struct hgros_session {
  std::unique_ptr<hgros::Session> session;
  std::shared_ptr<hgros::c::Life> life;
};

namespace hgros::c {

// A session that can be used; throws otherwise.
inline hgros_session& Opened(hgros_session* session) {
  hgros_session& on = Given(session, "session");
  if (on.life->closed()) throw SessionClosed();
  return on;
}
inline std::shared_ptr<const Life> LifeOf(const hgros_session* session) {
  return session == nullptr ? nullptr : session->life;
}
inline const hgros_session& Opened(const hgros_session* session) { return Opened(const_cast<hgros_session*>(session)); }

}  // namespace hgros::c
