#pragma once

#include <string>

#include "foxglove/LaserScan.pb.h"
#include "viewer/data/points/point_batch.hpp"

namespace hgros::viewer {

/// Reads the end points of a scan's rays. Ranges that are not finite and positive are left out. The scalars are the
/// intensities if there are any, or else the ranges. Returns what is wrong with the scan, or nothing.
[[nodiscard]] std::string ReadScan(const foxglove::LaserScan& scan, PointBatch& batch);

}  // namespace hgros::viewer
