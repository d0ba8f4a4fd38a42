#pragma once

#include <optional>

namespace hgros::viewer {

/// The point that was found nearest to a place so far.
struct NearestPoint {
  double distance_m = 0;       ///< What is further away counts no more.
  std::optional<float> value;  ///< Of its field, if points have one.
};

}  // namespace hgros::viewer
