#include "graph/nodes/node_stats.hpp"

#include "hgros/base/thread_local.hpp"

namespace hgros {

std::size_t ThisThreadShard() noexcept {
  static std::atomic<std::size_t> next{0};
  HGROS_THREAD_LOCAL const std::size_t shard = next.fetch_add(1, std::memory_order_relaxed) % kShards;
  return shard;
}

}  // namespace hgros
