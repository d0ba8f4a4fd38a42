#pragma once

#include <cstdint>
#include <optional>

#include "hgros/clock/time.hpp"

namespace hgros {

/// Names a frame of one TransformTree, for hot loops: a lookup by id hashes and compares no text. In another tree the
/// same id means another frame or no frame.
struct FrameId {
  std::uint32_t value = UINT32_MAX;
  bool operator==(const FrameId&) const = default;
};

/// Names a publisher of transforms in one TransformTree.
struct PublisherId {
  std::uint32_t value = 0;  ///< 0: unknown.
  bool operator==(const PublisherId&) const = default;
};

/// Asks a TransformTree for T_target_source at some time.
struct TransformQuery {
  FrameId target;
  FrameId source;
  FrameId fixed = {};                    ///< Only for time travel.
  std::optional<Time> source_time = {};  ///< Empty: the latest time that all edges on the way have.
  std::optional<Time> target_time = {};  ///< Only for time travel; otherwise source_time is used for both.
  bool travels = false;

  TransformQuery(FrameId to, FrameId from) : target(to), source(from) {}
  TransformQuery(FrameId to, FrameId from, Time at) : target(to), source(from), source_time(at) {}
  /// Time travel: the pose at `to_time` in `to` of something that was in `from` at `from_time`, if `still` does not
  /// move: T_target_fixed at `to_time` times T_fixed_source at `from_time`.
  TransformQuery(FrameId to, Time to_time, FrameId from, Time from_time, FrameId still)
      : target(to), source(from), fixed(still), source_time(from_time), target_time(to_time), travels(true) {}
};

}  // namespace hgros
