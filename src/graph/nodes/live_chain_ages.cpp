#include "graph/nodes/live_chain_ages.hpp"

#include <algorithm>
#include <memory>
#include <new>

namespace hgros {

LiveChainAges::~LiveChainAges() {
  for (std::atomic<Ages*>& slot : slots_) delete slot.load(std::memory_order_relaxed);
}

void LiveChainAges::RecordOther(std::uint32_t origin, std::int64_t age_ns, Writers writers) noexcept {
  for (std::atomic<Ages*>& slot : slots_) {
    const bool last = &slot == &slots_.back();
    Ages* found = slot.load(std::memory_order_acquire);
    if (found == nullptr) {
      std::unique_ptr<Ages> made(new (std::nothrow) Ages);
      if (!made) return;  // Without memory it is not counted.
      made->origin = last ? 0 : origin;
      if (slot.compare_exchange_strong(found, made.get(), std::memory_order_acq_rel)) found = made.release();
    }
    if (last || found->origin == origin) return found->age.Record(age_ns, writers);
  }
}

void LiveChainAges::AddTo(std::vector<ChainAges>& all) const {
  for (const std::atomic<Ages*>& slot : slots_) {
    const Ages* const one = slot.load(std::memory_order_acquire);
    if (one == nullptr) return;
    auto entry = std::ranges::find(all, one->origin, &ChainAges::origin);
    if (entry == all.end()) entry = all.insert(entry, {one->origin, {}});
    one->age.AddTo(entry->age);
  }
}

}  // namespace hgros
