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

#include "hgros/base/forced_unwind.hpp"
#include "hgros/c/status.h"
#include "hgros/internal/base/call_site.hpp"

// How a function of the C interface calls C++, and how C++ calls back.
namespace hgros::c {

inline constexpr std::string_view kSessionClosed = "The session has ended.";
inline constexpr std::string_view kOfParent =
    "It belongs to the session of another process, from which this one was forked. Make a session after the fork, and "
    "use that.";
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
// The session cannot be used any more; becomes HGROS_CLOSED.
class SessionClosed : public std::exception {
 public:
  explicit SessionClosed(std::string_view why) : why_(why) {}
  [[nodiscard]] const char* what() const noexcept override { return why_.data(); }

 private:
  std::string_view why_;  // A constant.
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

bool IsStructSize(std::size_t size) noexcept;
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

}  // namespace hgros::c
