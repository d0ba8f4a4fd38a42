#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros {

/// One edge of a TransformTree at one moment.
struct EdgeSnapshot {
  std::string parent;
  std::string child;
  std::string publisher;  ///< The last publisher; empty if unknown.
  bool is_static = false;
  RigidTransform T_parent_child;  ///< The newest transform.
  Time oldest;                    ///< The oldest stamp in the buffer; Time{} for static edges.
  Time newest;
  std::size_t transforms = 0;  ///< Number of transforms in the buffer.
  std::uint64_t sets = 0;      ///< Number of transforms set since the start.

  /// Transforms per second over the buffer; 0 for static edges and for fewer than two transforms.
  [[nodiscard]] double RateHz() const noexcept {
    if (is_static || transforms < 2 || newest <= oldest) return 0;
    return static_cast<double>(transforms - 1) * 1e9 / static_cast<double>((newest - oldest).count());
  }
};

}  // namespace hgros
