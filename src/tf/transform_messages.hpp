#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::tf {

inline constexpr std::int64_t kNanosPerSecond = 1'000'000'000;

void Append(foxglove::FrameTransforms& message, std::string_view parent, std::string_view child, Time stamp,
            const RigidTransform& T_parent_child);

/// A protobuf time. Empty if nanoseconds cannot represent it.
[[nodiscard]] inline std::optional<Time> TimeOf(std::int64_t seconds, std::int64_t nanos) noexcept {
  std::int64_t time = 0;
  if (nanos < 0 || nanos >= kNanosPerSecond || __builtin_mul_overflow(seconds, kNanosPerSecond, &time) ||
      __builtin_add_overflow(time, nanos, &time)) {
    return std::nullopt;
  }
  return Time{time};
}
[[nodiscard]] std::optional<Time> StampOf(const foxglove::FrameTransform& message);
/// The values are not checked: the tree refuses invalid rotations. A missing rotation is the identity.
[[nodiscard]] RigidTransform TransformOf(const foxglove::FrameTransform& message);

}  // namespace hgros::tf
