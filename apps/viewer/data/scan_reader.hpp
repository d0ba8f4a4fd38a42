#pragma once

#include <string>

#include "foxglove/LaserScan.pb.h"
#include "viewer/data/point_batch.hpp"

namespace hgros::viewer {

/// Reads the end points of a scan's rays; ranges that are no finite positive number are left out. The scalars are the
/// intensities where there are some, else the ranges. Returns what is wrong with the scan, or nothing.
[[nodiscard]] std::string ReadScan(const foxglove::LaserScan& scan, PointBatch& batch);

}  // namespace hgros::viewer
