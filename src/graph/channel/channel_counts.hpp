#pragma once

#include <atomic>
#include <cstdint>

#include "hgros/graph/snapshot.hpp"

namespace hgros {

// What a channel counts besides its own messages. ChannelSnapshot explains each.
//
// Thread safety: all members.
struct ChannelCounts {
  using Count = std::atomic<std::uint64_t>;
  Count refused{0};
  Count not_latched{0};
  Count received{0};
  Count converted{0};
  Count not_converted{0};

  void Fill(ChannelSnapshot& snapshot) const noexcept {
    snapshot.refused = refused.load(std::memory_order_relaxed);
    snapshot.not_latched = not_latched.load(std::memory_order_relaxed);
    snapshot.received = received.load(std::memory_order_relaxed);
    snapshot.converted = converted.load(std::memory_order_relaxed);
    snapshot.not_converted = not_converted.load(std::memory_order_relaxed);
  }
};

}  // namespace hgros
