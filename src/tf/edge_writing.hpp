#pragma once

#include <cstdint>

#include "tf/frame.hpp"

namespace hgros::tf {

/// Gives a frame its first transform; nobody reads it yet.
void BeginEdge(Frame& edge, bool is_static, const RingLimits& limits, const StampedPose& first);

/// Takes a transform into an edge that is there; the caller holds `edge.write`. False if its stamp lies before what the
/// buffer keeps.
[[nodiscard]] bool Write(Frame& edge, const StampedPose& value);

/// `value` instead of all that a moving edge has; the caller holds `edge.write`.
void WriteAnew(Frame& edge, const StampedPose& value);

}  // namespace hgros::tf
