#pragma once

#include <optional>
#include <string_view>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::tf {

void Append(foxglove::FrameTransforms& message, std::string_view parent, std::string_view child, Time stamp,
            const RigidTransform& T_parent_child);

/// Nothing if that is no time.
[[nodiscard]] std::optional<Time> StampOf(const foxglove::FrameTransform& message);
/// As it stands there: the tree refuses what is no rotation. A rotation that is left out is none.
[[nodiscard]] RigidTransform TransformOf(const foxglove::FrameTransform& message);

}  // namespace hgros::tf
