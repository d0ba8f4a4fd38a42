#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "pose2.hpp"
#include "scan_matcher.hpp"

namespace slam2d {

/// A verified relative pose: the laser at `stamp_2_seconds` as seen from the laser at `stamp_1_seconds`.
struct Relation {
  double stamp_1_seconds = 0.0;
  double stamp_2_seconds = 0.0;
  Pose2 T_1_2;
};

/// Distance of a trajectory from a set of relations (Kuemmerle et al., On Measuring the Accuracy of SLAM Algorithms,
/// Autonomous Robots 27, 2009, eq. 4): mean and standard deviation of the lengths and of the absolute angles of
/// Inverse(T_1_2) * (the trajectory's own relative pose).
struct RelationsError {
  std::size_t relations = 0;  ///< Number of relations with both stamps found.
  std::size_t unmatched = 0;
  double mean_translation_m = 0.0;
  double std_translation_m = 0.0;
  double max_translation_m = 0.0;
  double mean_rotation_rad = 0.0;
  double std_rotation_rad = 0.0;
};

/// Reads lines of `stamp1 stamp2 x y z roll pitch yaw`. Ignores z, roll and pitch.
///
/// Errors: throws std::runtime_error with file and line if the file cannot be opened or a line does not parse.
[[nodiscard]] std::vector<Relation> ReadRelations(const std::filesystem::path& path);

/// The pose of a stamp is the trajectory's nearest one, if it is within `tolerance_seconds`.
[[nodiscard]] RelationsError CompareWithRelations(std::span<const ScanMatch> trajectory,
                                                  std::span<const Relation> relations, double tolerance_seconds = 0.01);

}  // namespace slam2d
