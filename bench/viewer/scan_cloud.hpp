#pragma once

#include <span>
#include <string>

#include <foxglove/PointCloud.pb.h>

#include "hgros/codec/bulk.hpp"

namespace hgros::bench::slam_run {

/// Writes a scan (x, y, z, intensity ...) into a cloud of exactly that number of bytes.
void WriteScan(std::span<const float> scan, const std::string& frame, Bulk<foxglove::PointCloud>& cloud);

}  // namespace hgros::bench::slam_run
