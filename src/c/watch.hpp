#pragma once

#include <atomic>
#include <memory>
#include <utility>

#include "hgros/c/observe.h"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/base/listeners.hpp"

// One of `subscription` and `listening` is in use.
struct hgros_watch {
  ~hgros_watch() { closed->store(true, std::memory_order_release); }

  // For a callback that is called more than once for one event.
  const std::shared_ptr<std::atomic<bool>> closed = std::make_shared<std::atomic<bool>>(false);
  hgros::Subscription subscription;
  hgros::Listening listening;
};
