#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "hgros/base/forced_unwind.hpp"
#include "hgros/c/status.h"
#include "hgros/internal/base/call_site.hpp"

// How a function of the C interface calls C++, and how C++ calls back.
namespace hgros::c {

inline constexpr std::string_view kSessionClosed = "The session has ended.";
// What errors name in place of a line of source.
inline constexpr CallSite kFromC{"a call of the C interface"};

// Remembers the sentence for hgros_last_error() and returns the status, also if there is no memory for the sentence.
hgros_status Fail(hgros_status status, std::initializer_list<std::string_view> parts) noexcept;
inline hgros_status Fail(hgros_status status, std::string_view sentence) noexcept { return Fail(status, {sentence}); }
// The same for the exception in flight.
hgros_status FailHere() noexcept;

// An argument that cannot be used; becomes HGROS_INVALID_ARGUMENT.
class InvalidArgument : public std::exception {
 public:
  explicit InvalidArgument(std::string sentence) : sentence_(std::move(sentence)) {}
  [[nodiscard]] const char* what() const noexcept override { return sentence_.c_str(); }

 private:
  std::string sentence_;
};
// The session has ended; becomes HGROS_CLOSED.
class SessionClosed : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return kSessionClosed.data(); }
};
[[noreturn]] void RefuseNull(const char* argument);

template <class T>
T& Given(T* pointer, const char* argument) {
  if (pointer == nullptr) RefuseNull(argument);
  return *pointer;
}
inline std::string_view Text(const char* text, const char* argument) { return &Given(text, argument); }
// Empty for NULL.
inline std::string_view TextOrNone(const char* text) noexcept { return text == nullptr ? std::string_view() : text; }
// A negative timeout means forever.
inline std::chrono::nanoseconds Timeout(std::int64_t timeout_ns) noexcept {
  return timeout_ns < 0 ? std::chrono::nanoseconds::max() : std::chrono::nanoseconds(timeout_ns);
}
// The caller frees it with hgros_text_free().
char* NewText(std::string_view text);

// Runs `run`, which returns a status or nothing. No exception leaves it; only a thread that is being cancelled unwinds.
template <class F>
hgros_status Guarded(F&& run) {
  try {
    if constexpr (std::is_void_v<std::invoke_result_t<F&>>) {
      run();
      return HGROS_OK;
    } else {
      return run();
    }
  } catch (const ForcedUnwind&) {
    throw;
  } catch (...) {
    return FailHere();
  }
}
// The same for a function that creates `*out`, which is null if it fails. Without a place for it nothing is made.
template <class T, class F>
hgros_status Creating(T** out, F&& make) {
  if (out != nullptr) *out = nullptr;
  return Guarded([&] {
    T*& place = Given(out, "the place for the result");
    place = make().release();
  });
}

// Throws unless it may be the size of a struct.
void RequireStructSize(std::size_t size);
// Throws if a caller that knows later fields, which begin at `from`, has set one of them.
void RequireZeros(const void* given, std::size_t from, std::size_t size);

// The struct of a caller that may have been compiled with an earlier or a later version: the fields that it has, the
// others 0. Null stands for all 0.
template <class T>
T OptionsFrom(const T* given) {
  T options{};
  if (given == nullptr) return options;
  RequireStructSize(given->size);
  RequireZeros(given, sizeof(T), given->size);
  std::memcpy(&options, given, std::min(given->size, sizeof(T)));
  options.size = sizeof(T);
  return options;
}
// Fields of a later version become 0.
template <class T>
void FillIn(T* out, T value) {
  const std::size_t size = Given(out, "the struct to fill in").size;
  RequireStructSize(size);
  value.size = size;
  std::memcpy(out, &value, std::min(size, sizeof(T)));
  if (size > sizeof(T)) std::memset(reinterpret_cast<std::byte*>(out) + sizeof(T), 0, size - sizeof(T));
}

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

 private:
  static thread_local const InCallback* innermost;
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
  static thread_local int depth;
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
