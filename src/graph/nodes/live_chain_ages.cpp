#include "graph/nodes/live_chain_ages.hpp"

#include <algorithm>
#include <memory>
#include <new>

namespace hgros {

LiveChainAges::~LiveChainAges() {
  for (Slot& slot : slots_) delete slot.ages.load(std::memory_order_relaxed);
}

LiveChainAges::Slot& LiveChainAges::SlotOf(std::uint32_t origin) noexcept {
  for (std::size_t i = 0; i < kOrigins; ++i) {
    std::uint32_t found = slots_[i].origin.load(std::memory_order_relaxed);
    if (found == 0 && slots_[i].origin.compare_exchange_strong(found, origin, std::memory_order_relaxed)) {
      return slots_[i];
    }
    if (found == origin) return slots_[i];
  }
  return slots_.back();
}

void LiveChainAges::RecordOther(std::uint32_t origin, std::int64_t age_ns, Writers writers) noexcept {
  Slot& slot = SlotOf(origin);
  Ages* ages = slot.ages.load(std::memory_order_acquire);
  if (ages == nullptr) {
    std::unique_ptr<Ages> made(new (std::nothrow) Ages{});
    if (!made) return;  // Without memory it is not counted.
    if (slot.ages.compare_exchange_strong(ages, made.get(), std::memory_order_acq_rel)) ages = made.release();
  }
  Count(*ages, age_ns, writers);
}

void LiveChainAges::AddTo(std::vector<ChainAges>& all) const {
  for (const Slot& slot : slots_) {
    const Ages* const ages = slot.ages.load(std::memory_order_acquire);
    if (ages == nullptr) continue;
    const std::uint32_t origin = slot.origin.load(std::memory_order_relaxed);
    auto entry = std::ranges::find(all, origin, &ChainAges::origin);
    if (entry == all.end()) entry = all.insert(entry, {origin, {}});
    std::uint64_t sum = 0;
    std::int64_t max = 0;
    for (std::size_t i = 0; i < ages->size(); ++i) {
      const std::uint32_t count = (*ages)[i].load(std::memory_order_relaxed);
      if (count == 0) continue;
      entry->age.AddToBucket(i, count);
      max = LogHistogram::UpperEdge(i);
      sum += count * static_cast<std::uint64_t>(max + (i == 0 ? 0 : LogHistogram::UpperEdge(i - 1))) / 2;
    }
    entry->age.AddTotals(sum, max);
  }
}

}  // namespace hgros
