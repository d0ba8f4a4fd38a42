#pragma once

#include <utility>

#include "hgros/c/observe.h"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/base/listeners.hpp"

// One of the two is in use.
struct hgros_watch {
  hgros::Subscription subscription;
  hgros::Listening listening;
};
