#pragma once

#include <cxxabi.h>

#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"

namespace hgros {

/// What pthread_exit() and pthread_cancel() throw on their thread. It must not be swallowed: the C library ends the
/// process then, without a word about the callback.
using ForcedUnwind = abi::__forced_unwind;

/// Logs that `callback` ends a thread of the library, and ends the process. `callback` begins the sentence. Call it
/// where a ForcedUnwind from a user's callback is caught.
[[noreturn]] HGROS_EXPORT void EndAfterForcedUnwind(Log& log, std::string_view callback) noexcept;

}  // namespace hgros
