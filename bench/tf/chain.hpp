#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::bench {

/// The data of both sides of the benchmark: a chain of frames "chain_frame_0" (the root) to "chain_frame_8". Every edge
/// is set at 100 Hz over 10 s, and both turns and moves.
inline constexpr int kDepth = 8;
inline constexpr std::int64_t kPeriod = 10'000'000;
inline constexpr int kSteps = 1000;
inline constexpr std::int64_t kStart = 1'700'000'000'000'000'000;

inline std::string FrameName(int level) { return "chain_frame_" + std::to_string(level); }
inline std::int64_t StampOf(int step) { return kStart + step * kPeriod; }
inline RigidTransform PoseAt(int level, int step) {
  const double t = step * 0.01;
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.3 * level, -0.5).normalized();
  return {RigidTransform::Rotation(Eigen::AngleAxisd(0.8 * t + level, axis)),
          Eigen::Vector3d(std::cos(t + level), std::sin(t), 0.1 * level)};
}

}  // namespace hgros::bench
