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
  std::string publisher;  ///< Who set it last; empty if nobody said.
  bool is_static = false;
  RigidTransform T_parent_child;  ///< The newest.
  Time oldest;                    ///< Of what is remembered; Time{} for static edges.
  Time newest;
  std::size_t transforms = 0;  ///< How many are remembered.
  std::uint64_t sets = 0;      ///< How many were taken since the beginning.

  /// Transforms per second, over what is remembered; 0 for static edges and where there are fewer than two.
  [[nodiscard]] double RateHz() const noexcept {
    if (is_static || transforms < 2 || newest <= oldest) return 0;
    return static_cast<double>(transforms - 1) * 1e9 / static_cast<double>((newest - oldest).count());
  }
};

}  // namespace hgros
