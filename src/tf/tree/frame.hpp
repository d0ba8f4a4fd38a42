#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <string>

#include "hgros/tf/transform_query.hpp"
#include "tf/tree/jump_watch.hpp"
#include "tf/tree/sample_ring.hpp"

namespace hgros::tf {

/// A frame and the edge to its parent. Frames live as long as their tree.
///
/// Thread safety: readers use the atomics. The rest is fixed before `parent` is set, or guarded by `write`.
/// Invariants: `parent` is set once. The ring has a transform before that. The ring's End grows with every change of
/// the edge, also when the ring is replaced.
struct alignas(64) Frame {
  // Fixed once there is a parent, except the ring, which is replaced after a transform out of order.
  std::atomic<Frame*> parent{nullptr};
  std::atomic<SampleRing*> ring{nullptr};
  RingLimits limits;
  std::atomic<bool> known{false};  ///< The frame has an edge.
  bool is_static = false;
  std::uint32_t height = 0;  ///< The most edges from here down to a frame. Guarded by the tree.
  FrameId id;
  // Changes with every transform.
  alignas(64) std::atomic<std::uint64_t> sets{0};
  std::atomic<std::uint32_t> publisher{0};
  std::mutex write;
  std::uint64_t time = 0;  ///< The tree's time when the edge was last set.
  std::int64_t newest = std::numeric_limits<std::int64_t>::min();
  JumpWatch jumps;
  std::int64_t awaited_from = std::numeric_limits<std::int64_t>::max();  ///< The lowest stamp for which a wait exists.
  std::array<std::unique_ptr<SampleRing>, 2> rings;  ///< Readers use one while the other is rewritten.
  // Never changes.
  std::size_t name_hash = 0;
  std::string name;
};

}  // namespace hgros::tf
