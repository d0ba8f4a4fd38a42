#include "hgros/bridge/outlet_latch.hpp"

#include <algorithm>
#include <utility>

namespace hgros {

OutletLatch::Messages OutletLatch::Keep(Kept&& message, std::size_t depth) {
  Messages dropped;
  const std::scoped_lock lock(mutex_);
  kept_.push_back(std::move(message));
  while (kept_.size() > depth) {
    dropped.push_back(std::move(kept_.front()));
    kept_.pop_front();
  }
  return dropped;
}

OutletLatch::Messages OutletLatch::All() const {
  const std::scoped_lock lock(mutex_);
  return kept_;
}

OutletLatch::Messages OutletLatch::Clear() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(kept_, {});
}

// A message that was promised before may have been kept after one that has stayed inside.
void OutletLatch::Sort() {
  std::ranges::stable_sort(kept_, {},
                           [](const Kept& one) { return std::pair(one.head.id.incarnation, one.head.id.sequence); });
}

}  // namespace hgros
