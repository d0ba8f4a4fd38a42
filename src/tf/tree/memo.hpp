#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tf/tree/edge_reading.hpp"
#include "tf/tree/route.hpp"

namespace hgros::tf {

/// One thread's cache for a pair of frames: the path between them, which never changes, and the latest transform with
/// the versions of its edges. Other threads never see it, so writing it does not slow them down.
struct Memo {
  static constexpr std::size_t kMostEdges = 16;  ///< Longer paths are not cached.

  std::uint64_t tree = 0;  ///< Unique, so that edges of destroyed trees are not used. 0: no tree.
  FrameId target;
  FrameId source;
  std::uint16_t source_edges = 0;  ///< Number of source edges; they come first in `edges`, then the target's.
  std::uint16_t all_edges = 0;
  bool has_latest = false;
  bool latest_is_static = false;
  std::int64_t latest_stamp = 0;
  Pose latest;
  std::array<const Frame*, kMostEdges> edges;
  std::array<std::uint64_t, kMostEdges> versions;

  [[nodiscard]] bool Is(std::uint64_t tree_number, FrameId to, FrameId from) const {
    return tree == tree_number && target == to && source == from;
  }
  [[nodiscard]] bool LatestHolds() const {
    if (!has_latest) return false;
    for (std::size_t i = 0; i < all_edges; ++i) {
      if (VersionOf(*edges[i]) != versions[i]) return false;
    }
    return true;
  }
  [[nodiscard]] std::span<const Frame* const> FromSource() const { return {edges.data(), source_edges}; }
  [[nodiscard]] std::span<const Frame* const> FromTarget() const {
    return {edges.data() + source_edges, static_cast<std::size_t>(all_edges - source_edges)};
  }

  /// The calling thread's entry for the pair. Another pair may occupy it.
  [[nodiscard]] static Memo& PlaceFor(std::uint64_t tree, FrameId target, FrameId source);
};

}  // namespace hgros::tf
