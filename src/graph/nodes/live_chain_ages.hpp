#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "graph/nodes/live_histogram.hpp"
#include "hgros/graph/snapshot.hpp"

namespace hgros {

// A histogram of ages for each origin of chains. A peer may write any origin, so there is room for 16; further origins
// share one histogram.
//
// Thread safety: Record() as Writers says; AddTo() from any thread.
class LiveChainAges {
 public:
  static constexpr std::size_t kOrigins = 16;

  LiveChainAges() = default;
  LiveChainAges(const LiveChainAges&) = delete;
  LiveChainAges& operator=(const LiveChainAges&) = delete;
  ~LiveChainAges();

  void Record(std::uint32_t origin, std::int64_t age_ns, Writers writers) noexcept {
    Ages* const first = slots_[0].load(std::memory_order_acquire);
    if (first != nullptr && first->origin == origin) return first->age.Record(age_ns, writers);
    RecordOther(origin, age_ns, writers);
  }
  // Adds to the entry of the same origin, or appends one.
  void AddTo(std::vector<ChainAges>& all) const;

 private:
  struct Ages {
    LiveHistogram age;
    std::uint32_t origin;  // Beside the sums of `age`, in one line of the cache.
  };

  void RecordOther(std::uint32_t origin, std::int64_t age_ns, Writers writers) noexcept;

  std::array<std::atomic<Ages*>, kOrigins + 1> slots_{};  // Filled from the front, and never changed then.
};

}  // namespace hgros
