#pragma once

#include <cstddef>
#include <cstdint>

#include "tf/frame.hpp"

namespace hgros::tf {

// Reading the edge of a frame that has a parent. None of these waits for a writer: what is seen while a transform comes
// in is either before or after it, and who has looked at something that was written over meanwhile looks again.

/// Grows with every change of the edge.
inline std::uint64_t VersionOf(const Frame& edge) { return edge.ring.load(std::memory_order_acquire)->End(); }

/// The newest transform and its stamp; of a static edge the one that always holds, and 0. `version` is not later.
inline std::int64_t ReadNewest(const Frame& edge, Pose& pose, std::uint64_t& version) {
  for (;;) {
    const SampleRing& ring = *edge.ring.load(std::memory_order_acquire);
    const std::uint64_t end = ring.End();
    const Sample& newest = ring.Newest();  // Number end - 1, or a later one.
    const std::int64_t stamp = newest.Stamp();
    newest.ReadTo(pose);
    if (!ring.StillThere(end - 1)) continue;
    version = end;
    return stamp;
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
