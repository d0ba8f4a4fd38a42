#pragma once

#include <filesystem>
#include <span>

#include "scan_matcher.hpp"

namespace slam2d {

/// Writes a trajectory in the TUM format: one line `stamp tx ty tz qx qy qz qw` per pose, in s and m
/// (https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats). Numbers have the fewest digits that read back as
/// the same double. tz, qx and qy are 0. Written under a temporary name, then renamed.
///
/// Errors: throws std::runtime_error with a sentence; `path` is then unchanged.
void WriteTrajectory(std::span<const ScanMatch> trajectory, const std::filesystem::path& path);

}  // namespace slam2d
