#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros::viewer {

/// The finite points of one message. There may be fewer than in the message.
struct PointBatch {
  std::string frame;
  Time stamp;
  RigidTransform T_frame_points;           ///< The message's pose, including the offset that keeps the positions small.
  std::vector<Eigen::Vector3f> positions;  ///< Meters.
  std::vector<float> scalars;              ///< The requested field: one value for each position, or none.
  std::vector<std::uint32_t> colors;  ///< One for each position, or none. Red in the lowest byte, alpha in the highest.
  std::string scalar_name;            ///< Name of the field in `scalars`.
  std::vector<std::string> fields;    ///< All fields that can be requested.
  std::size_t left_out = 0;           ///< Points without a finite position, or far from all others.
};

}  // namespace hgros::viewer
