#pragma once

#include <filesystem>
#include <span>

#include "scan_matcher.hpp"

namespace slam2d {

/// Writes a trajectory in the TUM format, a line `stamp tx ty tz qx qy qz qw` a pose, in s and m
/// (https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats). Numbers have the fewest digits from which the
/// same double is read again; tz, qx and qy are 0. Written under a temporary name, then renamed.
///
/// Errors: throws std::runtime_error with a sentence; `path` is then as it was before.
void WriteTrajectory(std::span<const ScanMatch> trajectory, const std::filesystem::path& path);

}  // namespace slam2d
