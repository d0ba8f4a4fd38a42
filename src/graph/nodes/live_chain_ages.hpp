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
// share one histogram. Only the buckets are counted, because each message touches one line of the cache less so.
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
    if (slots_[0].origin.load(std::memory_order_relaxed) == origin) {
      if (Ages* const ages = slots_[0].ages.load(std::memory_order_acquire)) return Count(*ages, age_ns, writers);
    }
    RecordOther(origin, age_ns, writers);
  }
  // Adds to the entry of the same origin, or appends one.
  void AddTo(std::vector<ChainAges>& all) const;

 private:
  using Ages = std::array<std::atomic<std::uint32_t>, LogHistogram::kBucketCount>;
  struct Slot {
    std::atomic<Ages*> ages{nullptr};      // Set once.
    std::atomic<std::uint32_t> origin{0};  // 0: free. Set once, before `ages`.
  };

  static void Count(Ages& ages, std::int64_t age_ns, Writers writers) noexcept {
    Add(ages[LogHistogram::BucketOf(age_ns)], std::uint32_t{1}, writers);
  }
  void RecordOther(std::uint32_t origin, std::int64_t age_ns, Writers writers) noexcept;
  [[nodiscard]] Slot& SlotOf(std::uint32_t origin) noexcept;

  std::array<Slot, kOrigins + 1> slots_{};  // Filled from the front; the last one is for further origins.
};

}  // namespace hgros
