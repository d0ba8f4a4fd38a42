#include "graph/channel/publish_rate.hpp"

#include <algorithm>

namespace hgros {
namespace {

constexpr std::uint64_t kLeastMessages = 8;

}  // namespace

void PublishRate::Mark(std::uint64_t sequence, std::int64_t now) noexcept {
  const std::uint64_t marked = mark_sequence_.load(std::memory_order_relaxed);
  if (marked != 0 && sequence < marked + kLeastMessages) return;
  std::int64_t mark = mark_ns_.load(std::memory_order_relaxed);
  if (now - mark < kSpanNs || !mark_ns_.compare_exchange_strong(mark, now, std::memory_order_relaxed)) return;
  earlier_ns_.store(mark, std::memory_order_relaxed);
  earlier_sequence_.store(marked, std::memory_order_relaxed);
  mark_sequence_.store(sequence, std::memory_order_relaxed);
}

double PublishRate::Hertz(std::uint64_t sequence, std::int64_t now) const noexcept {
  std::uint64_t first = earlier_sequence_.load(std::memory_order_relaxed);
  std::int64_t since = earlier_ns_.load(std::memory_order_relaxed);
  if (first == 0) {
    first = mark_sequence_.load(std::memory_order_relaxed);
    since = mark_ns_.load(std::memory_order_relaxed);
  }
  if (first == 0 || sequence <= first) return 0;
  const auto count = static_cast<double>(sequence - first);
  const std::int64_t last = std::max(last_ns_.load(std::memory_order_relaxed), since + 1);
  const double period = static_cast<double>(last - since) / count;
  const auto silence = static_cast<double>(now - last);
  // The next message may be late by as much as its period before the rate falls.
  return silence <= 2 * period ? 1e9 / period : 1e9 * count / static_cast<double>(now - since);
}

}  // namespace hgros
