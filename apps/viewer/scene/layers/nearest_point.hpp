#pragma once

#include <optional>

namespace hgros::viewer {

/// The nearest point that was found so far.
struct NearestPoint {
  double distance_m = 0;       ///< Points farther away are ignored.
  std::optional<float> value;  ///< Value of its field, if points have one.
};

}  // namespace hgros::viewer
