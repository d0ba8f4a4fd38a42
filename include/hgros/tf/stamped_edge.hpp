#pragma once

#include <string>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros {

/// One transform of one edge: p_parent = T_parent_child * p_child at `stamp`.
struct StampedEdge {
  std::string parent;
  std::string child;
  Time stamp;
  RigidTransform T_parent_child;
};

}  // namespace hgros
