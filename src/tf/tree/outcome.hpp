#pragma once

#include <cstdint>

#include "hgros/tf/transform_result.hpp"
#include "tf/tree/frame.hpp"
#include "tf/tree/pose.hpp"

namespace hgros::tf {

/// The result of a lookup without texts, which are made only when they are requested.
struct Outcome {
  TransformFault fault = TransformFault::kNone;
  Pose pose;  ///< Valid only if found.
  std::int64_t stamp = 0;
  bool is_static = false;  ///< All edges on the path are static.

  // For a fault.
  FrameId target;  ///< The part that failed, for time travel.
  FrameId source;
  FrameId unknown;
  std::int64_t wanted = 0;         ///< kTooOld, kTooNew
  const Frame* edge = nullptr;     ///< kTooOld, kTooNew
  const Frame* lagging = nullptr;  ///< kTooOld in a lookup of the latest: the edge that is behind `edge`.
  const Frame* target_root = nullptr;
  const Frame* source_root = nullptr;
};

}  // namespace hgros::tf
