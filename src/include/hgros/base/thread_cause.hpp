#pragma once

#include "hgros/base/cause.hpp"

namespace hgros {

// The calling thread's cause; null: none. Hidden, so that one call finds it together with other variables of the
// thread.
[[gnu::visibility("hidden")]] extern constinit thread_local const Cause* thread_cause;

}  // namespace hgros
