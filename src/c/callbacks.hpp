#pragma once

#include <memory>
#include <utility>

#include "c/calling.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/c/status.h"

namespace hgros::c {

// Marks this thread as running a callback of an object, such as a session, while it lives. Marks nest.
class InCallback {
 public:
  explicit InCallback(const void* of) noexcept : of_(of), outer_(innermost) { innermost = this; }
  InCallback(const InCallback&) = delete;
  InCallback& operator=(const InCallback&) = delete;
  ~InCallback() { innermost = outer_; }
  [[nodiscard]] static bool Of(const void* object) noexcept {
    for (const InCallback* one = innermost; one != nullptr; one = one->outer_) {
      if (one->of_ == object) return true;
    }
    return false;
  }
  // That of any object.
  [[nodiscard]] static bool Here() noexcept { return innermost != nullptr; }

 private:
  static HGROS_THREAD_LOCAL const InCallback* innermost;
  const void* const of_;
  const InCallback* const outer_;
};

// Marks this thread as one of the program that closes a handle, while it lives. Marks nest.
class InClose {
 public:
  InClose() noexcept { ++depth; }
  InClose(const InClose&) = delete;
  InClose& operator=(const InClose&) = delete;
  ~InClose() { --depth; }
  [[nodiscard]] static bool Here() noexcept { return depth > 0; }

 private:
  static HGROS_THREAD_LOCAL int depth;
};

// The objects for which a callback is called: a session's life, and parameters.
struct CallbackOf {
  std::shared_ptr<const void> life;
  std::shared_ptr<const void> held;
};

// What a program passes to its callback, and lets go when no call can come any more. That may be on the thread that has
// just run the callback, so it counts as a callback, too, unless the program closes the handle on a thread of its own.
class User {
 public:
  User(void* user, hgros_release release, CallbackOf of = {}) noexcept
      : user_(user), release_(release), of_(std::move(of)) {}
  User(const User&) = delete;
  User& operator=(const User&) = delete;
  ~User() {
    if (release_ == nullptr) return;
    if (InClose::Here()) {
      release_(user_);
      return;
    }
    const InCallback inside(of_.life.get());
    const InCallback inside_held(of_.held.get());
    release_(user_);
  }
  [[nodiscard]] void* get() const noexcept { return user_; }
  // The program keeps it. Only while nobody else uses this object.
  void GiveBack() noexcept { release_ = nullptr; }

 private:
  void* const user_;
  hgros_release release_;
  const CallbackOf of_;
};

// Lets `user` go in any case, also if there is no memory.
inline std::shared_ptr<User> KeepUser(void* user, hgros_release release, CallbackOf of) {
  try {
    return std::make_shared<User>(user, release, std::move(of));
  } catch (...) {
    if (release != nullptr) release(user);
    throw;
  }
}
// Creating() for what has a callback: `make` gets its User, which is let go whatever happens.
template <class T, class F>
hgros_status CreatingFor(CallbackOf of, void* user, hgros_release release, T** out, F&& make) {
  if (out != nullptr) *out = nullptr;
  return Guarded([&] {
    const std::shared_ptr<const User> kept = KeepUser(user, release, std::move(of));
    T*& place = Given(out, "the place for the result");
    place = make(kept).release();
  });
}

}  // namespace hgros::c
