#pragma once

#include <string>

#include "c/calling.hpp"
#include "hgros/c/subscribe.h"
#include "hgros/graph/executor.hpp"

namespace hgros::c {

inline Executor ExecutorOf(std::int32_t executor) {
  switch (executor) {
    case HGROS_EXECUTOR_WORKERS: return Executor::Tbb();
    case HGROS_EXECUTOR_INLINE: return Executor::Inline();
    case HGROS_EXECUTOR_DEDICATED: return Executor::Dedicated();
    default: throw InvalidArgument("There is no executor " + std::to_string(executor) + ". Use HGROS_EXECUTOR_...");
  }
}

}  // namespace hgros::c
