#pragma once

#include <cstddef>
#include <cstdint>

#include "tf/frame.hpp"

namespace hgros::tf {

// Reading the edge of a frame that has a parent. None of these waits for a writer: what is seen while a transform comes
// in is either before or after it, and who has looked at something that was written over meanwhile looks again.

/// The newest transform; of a static edge the one that always holds.
inline StampedPose ReadNewest(const Frame& edge) {
  for (;;) {
    const SampleRing& ring = *edge.ring.load(std::memory_order_acquire);
    const SampleRing::Window window = ring.Look(edge.limits.count);
    if (window.begin >= window.end) continue;  // A ring that is no longer in use.
    const Sample& sample = window[window.end - 1];
    const StampedPose newest{sample.Stamp(), sample.Read()};
    if (ring.StillThere(window.end - 1)) return newest;
  }
}

enum class Reading : std::uint8_t { kFound, kTooOld, kTooNew };

/// The transform at a moment, interpolated if need be.
[[nodiscard]] Reading ReadAt(const Frame& edge, std::int64_t stamp, Pose& pose);

struct EdgeRange {
  std::int64_t oldest = 0;
  std::int64_t newest = 0;
  std::size_t count = 0;
};
/// What the edge remembers.
[[nodiscard]] EdgeRange ReadRange(const Frame& edge);

}  // namespace hgros::tf
