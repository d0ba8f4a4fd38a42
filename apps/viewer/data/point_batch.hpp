#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// The points of one message as the displays take them: finite ones only, so there may be fewer than the message has.
struct PointBatch {
  std::string frame;
  Time stamp;
  RigidTransform T_frame_points;  ///< The message's pose, together with the shift that keeps the positions small.
  std::vector<Eigen::Vector3f> positions;  ///< Metres.
  std::vector<float> scalars;              ///< One for each position, or none: the field that was asked for.
  std::vector<std::uint32_t> colors;       ///< Likewise; red in the lowest byte, alpha in the highest.
  std::string scalar_name;                 ///< Of the field in `scalars`.
  std::vector<std::string> fields;         ///< Those that could be asked for.
  std::size_t left_out = 0;                ///< Points without a finite position.
};

}  // namespace hgros::viewer
