#include "graph/channel/publish_rate.hpp"

#include <algorithm>
#include <mutex>

namespace hgros {
namespace {

constexpr std::uint64_t kLeastMessages = 8;

}  // namespace

void PublishRate::Mark(std::uint64_t sequence, std::int64_t now) noexcept {
  const std::uint64_t marked = mark_sequence_.load(std::memory_order_relaxed);
  if (marked != 0 && sequence < marked + kLeastMessages) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  const std::int64_t mark = mark_ns_.load(std::memory_order_relaxed);
  if (!lock || now - mark < kSpanNs) return;  // Another thread does it, or has done it.
  earlier_ns_ = mark;
  earlier_sequence_ = mark_sequence_.load(std::memory_order_relaxed);
  mark_sequence_.store(sequence, std::memory_order_relaxed);
  mark_ns_.store(now, std::memory_order_relaxed);
}

double PublishRate::Hertz(std::uint64_t sequence, std::int64_t now) const noexcept {
  const std::scoped_lock lock(mutex_);
  const bool has_earlier = earlier_sequence_ != 0;
  const std::uint64_t first = has_earlier ? earlier_sequence_ : mark_sequence_.load(std::memory_order_relaxed);
  const std::int64_t since = has_earlier ? earlier_ns_ : mark_ns_.load(std::memory_order_relaxed);
  if (first == 0 || sequence <= first) return 0;
  const std::int64_t last = std::max(last_ns_.load(std::memory_order_relaxed), since + 1);
  const auto measured = static_cast<double>(last - since);
  const auto silence = static_cast<double>(now - last);
  if (silence > measured) return 1e9 / silence;
  const auto count = static_cast<double>(sequence - first);
  // The next message may be late by as much as its period before the rate falls.
  return silence <= 2 * measured / count ? 1e9 * count / measured : 1e9 * count / (measured + silence);
}

}  // namespace hgros
