#pragma once

#include <cstdint>

#include "tf/tree/frame.hpp"

namespace hgros::tf {

/// Gives a frame its first transform, before any reader sees it.
void BeginEdge(Frame& edge, bool is_static, const RingLimits& limits, const StampedPose& first);

/// Writes a transform into an existing edge; the caller holds `edge.write`. False if its stamp is before the buffer's
/// range.
[[nodiscard]] bool Write(Frame& edge, const StampedPose& value);

/// Replaces all transforms of a moving edge by `value`; the caller holds `edge.write`.
void Rewrite(Frame& edge, const StampedPose& value);

}  // namespace hgros::tf
