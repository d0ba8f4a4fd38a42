#include "tf/tree/edge_reading.hpp"

#include <algorithm>

#include "tf/tree/slerp.hpp"

namespace hgros::tf {
namespace {

using Number = std::uint64_t;

// Finds the last transform at or before a stamp. It begins at the position that follows from the edge's rate, and
// remembers the lowest number that it has read.
class Search {
 public:
  Search(const SampleRing::Window& window, Number guess) : window_(window), lowest_(window.end), guess_(guess) {}

  // Number `end` counts as later than `stamp`. False if no transform is at or before it.
  bool LastAtOrBefore(std::int64_t stamp, Number begin, Number end, Number& found) {
    Number low = begin;  // All lower numbers are at or before the stamp.
    Number high = end;   // This number and all higher ones are after the stamp.
    Number probe = std::clamp(guess_, low, high - 1);
    for (Number step = 1; low < high;) {
      if (StampOf(probe) <= stamp) {
        low = probe + 1;
        if (low >= high) break;
        probe = low + std::min(step, high - low) - 1;
        if (step > kGallop) probe = low + (high - low) / 2;
      } else {
        high = probe;
        if (low >= high) break;
        probe = high - std::min(step, high - low);
        if (step > kGallop) probe = low + (high - low) / 2;
      }
      step *= 2;
    }
    found = low - 1;
    return low > begin;
  }

  [[nodiscard]] std::int64_t StampOf(Number number) {
    lowest_ = std::min(lowest_, number);
    return window_[number].Stamp();
  }
  [[nodiscard]] Number lowest() const { return lowest_; }

 private:
  static constexpr Number kGallop = 8;  // After a step of this length, bisection is faster.

  const SampleRing::Window& window_;
  Number lowest_;
  Number guess_;
};

Number Guess(const SampleRing& ring, const SampleRing::Window& window, std::int64_t newest, std::int64_t stamp) {
  const double steps_back = static_cast<double>(Between(stamp, newest)) * ring.Rate() + 1;
  const Number last = window.end - 1;
  return steps_back < static_cast<double>(last - window.begin) ? last - static_cast<Number>(steps_back) : window.begin;
}

// The lowest number that counts.
Number FirstThatCounts(Search& search, const SampleRing::Window& window, std::int64_t oldest) {
  Number before = 0;
  return oldest > INT64_MIN && search.LastAtOrBefore(oldest - 1, window.begin, window.end - 1, before) ? before + 1
                                                                                                       : window.begin;
}

// After the window there is at most one transform, which its writer has not counted yet; ReadNewest already returns
// it. The caller makes sure that the count has not changed meanwhile.
Reading ReadAhead(const Frame& edge, const SampleRing& ring, const SampleRing::Window& window, std::int64_t stamp,
                  Pose& pose) {
  const Sample& ahead = ring.Newest();
  const std::int64_t to = ahead.Stamp();
  if (to < stamp) return Reading::kTooNew;
  ahead.ReadTo(pose);
  if (to == stamp) return Reading::kFound;
  const Sample& last = window[window.end - 1];
  const std::int64_t from = last.Stamp();
  if (from < edge.limits.OldestFor(to)) return Reading::kTooOld;
  pose = Interpolated(last.Read(), pose,
                      static_cast<double>(Between(from, stamp)) / static_cast<double>(Between(from, to)));
  return Reading::kFound;
}

}  // namespace

Reading ReadAt(const Frame& edge, std::int64_t stamp, Pose& pose) {
  for (;;) {
    const SampleRing& ring = *edge.ring.load(std::memory_order_acquire);
    const SampleRing::Window window = ring.Look(edge.limits.count);
    if (window.begin >= window.end) continue;  // A ring that is no longer in use.
    const Number last = window.end - 1;
    const std::int64_t newest = window[last].Stamp();
    if (edge.is_static || stamp == newest) {
      window[last].ReadTo(pose);
      if (!ring.StillThere(last)) continue;
      return Reading::kFound;
    }
    if (stamp > newest) {
      const Reading reading = ReadAhead(edge, ring, window, stamp, pose);
      if (ring.End() != window.end || !ring.StillThere(last)) continue;
      return reading;
    }
    const std::int64_t oldest = edge.limits.OldestFor(newest);
    if (stamp < oldest || last == window.begin) {
      if (!ring.StillThere(last)) continue;
      return Reading::kTooOld;
    }

    Search search(window, Guess(ring, window, newest, stamp));
    Number before = 0;
    bool there = search.LastAtOrBefore(stamp, window.begin, last, before);
    if (there) {
      const std::int64_t from = window[before].Stamp();
      there = from >= oldest;
      const Pose a = window[before].Read();
      if (from == stamp) {
        pose = a;
      } else if (there) {
        const std::int64_t to = window[before + 1].Stamp();
        pose = Interpolated(a, window[before + 1].Read(),
                            static_cast<double>(Between(from, stamp)) / static_cast<double>(Between(from, to)));
      }
    }
    if (ring.StillThere(search.lowest())) return there ? Reading::kFound : Reading::kTooOld;
  }
}

EdgeRange ReadRange(const Frame& edge) {
  for (;;) {
    const SampleRing& ring = *edge.ring.load(std::memory_order_acquire);
    const SampleRing::Window window = ring.Look(edge.limits.count);
    if (window.begin >= window.end) continue;  // A ring that is no longer in use.
    const Number last = window.end - 1;
    EdgeRange range;
    range.newest = window[last].Stamp();
    Search search(window, window.begin);
    const Number first =
        last == window.begin ? last : FirstThatCounts(search, window, edge.limits.OldestFor(range.newest));
    range.oldest = search.StampOf(first);
    range.count = static_cast<std::size_t>(window.end - first);
    if (ring.StillThere(search.lowest())) return range;
  }
}

}  // namespace hgros::tf
