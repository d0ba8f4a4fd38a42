#pragma once

#include <vector>

#include "hgros/tf/stamped_edge.hpp"

namespace hgros::tf {

/// A component that sets static edges. Guarded by the mutex of the session's TransformSender.
struct EdgeSetter {
  struct Withheld {
    StampedEdge edge;
    bool by_constructor = false;
  };
  bool constructing = false;
  bool withholds = false;          // Its edges are not sent, but kept here, in the order in which they were set.
  std::vector<Withheld> withheld;  // Perhaps with several transforms of an edge.
};

}  // namespace hgros::tf
