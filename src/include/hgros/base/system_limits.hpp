#pragma once

#include <cstddef>
#include <string_view>
#include <system_error>
#include <utility>

#include "hgros/base/export.hpp"

namespace hgros {

/// How many files this process may have open.
[[nodiscard]] HGROS_EXPORT std::size_t DescriptorLimit() noexcept;

/// How many more files this process can open by its own limit; counts no further than `most`. Opens none.
[[nodiscard]] HGROS_EXPORT std::size_t FreeDescriptors(std::size_t most) noexcept;

/// Throws Error if fewer than `count` more files can be opened. `what` begins the sentence: "Cannot publish at
/// tcp://..."
HGROS_EXPORT void RequireDescriptors(std::size_t count, std::string_view what);

/// Throws Error if this process cannot have `count` more threads: starts them, and ends them again. For libraries that
/// end the process when they cannot start a thread. `what` completes "Cannot start ...".
HGROS_EXPORT void RequireThreads(std::size_t count, std::string_view what);

/// Throws the Error of a thread that could not be started. `what` completes "Cannot start ...".
[[noreturn]] HGROS_EXPORT void ThrowNoThread(std::string_view what);

/// Starts a std::thread or std::jthread. Throws Error. `what` completes "Cannot start ...".
template <class Thread, class Body>
[[nodiscard]] Thread StartThread(std::string_view what, Body&& body) {
  try {
    return Thread(std::forward<Body>(body));
  } catch (const std::system_error&) {
    ThrowNoThread(what);
  }
}

}  // namespace hgros
