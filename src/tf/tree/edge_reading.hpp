#pragma once

#include <cstddef>
#include <cstdint>

#include "tf/tree/frame.hpp"

namespace hgros::tf {

// Reads the edge of a frame that has a parent. No function waits for a writer: it sees the edge before or after a
// change, and reads again if a transform was overwritten meanwhile.

/// Grows with every change of the edge.
inline std::uint64_t VersionOf(const Frame& edge) { return edge.ring.load(std::memory_order_acquire)->End(); }

/// The newest transform and its stamp; for a static edge its transform and 0. `version` is not newer.
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

/// The transform at a time, interpolated if necessary.
[[nodiscard]] Reading ReadAt(const Frame& edge, std::int64_t stamp, Pose& pose);

struct EdgeRange {
  std::int64_t oldest = 0;
  std::int64_t newest = 0;
  std::size_t count = 0;
};
/// The range of the edge's buffer.
[[nodiscard]] EdgeRange ReadRange(const Frame& edge);

}  // namespace hgros::tf
