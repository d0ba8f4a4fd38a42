#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "graph/nodes/live_chain_ages.hpp"
#include "graph/nodes/live_histogram.hpp"

namespace hgros {

// The counters of a node's running callbacks. One per node, or one per shard if many threads run it at once.
struct alignas(64) NodeStats {
  std::atomic<std::uint64_t> run{0};
  std::atomic<std::uint64_t> failed{0};
  std::atomic<std::uint64_t> refused{0};
  LiveChainAges ages;
  LiveHistogram queue_wait;
  LiveHistogram run_time;
};

// A small number for the calling thread, to spread shared counters over cache lines.
std::size_t ThisThreadShard() noexcept;
inline constexpr std::size_t kShards = 8;

}  // namespace hgros
