#pragma once

#include "hgros/base/cause.hpp"
#include "hgros/base/thread_local.hpp"

namespace hgros {

// The calling thread's cause; null: none. Hidden, so that one call finds it together with other variables of the
// thread.
[[gnu::visibility("hidden")]] extern constinit HGROS_THREAD_LOCAL const Cause* thread_cause;

}  // namespace hgros
