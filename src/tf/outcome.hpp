#pragma once

#include <cstdint>

#include "hgros/tf/transform_result.hpp"
#include "tf/frame.hpp"
#include "tf/pose.hpp"

namespace hgros::tf {

/// What a look-up came to, without words: those are made only for who wants to read them.
struct Outcome {
  TransformFault fault = TransformFault::kNone;
  Pose pose;  ///< Not set before it is found.
  std::int64_t stamp = 0;
  bool is_static = false;  ///< Nothing but static edges on the way.

  // Of a fault.
  FrameId target;  ///< Of the part that failed, for time travel.
  FrameId source;
  FrameId unknown;
  std::int64_t wanted = 0;         ///< kTooOld, kTooNew
  const Frame* edge = nullptr;     ///< kTooOld, kTooNew
  const Frame* lagging = nullptr;  ///< kTooOld, of a look-up of the latest: the edge that is behind `edge`.
  const Frame* target_root = nullptr;
  const Frame* source_root = nullptr;
};

}  // namespace hgros::tf
