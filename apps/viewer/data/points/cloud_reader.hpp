#pragma once

#include <string>
#include <string_view>

#include "foxglove/PointCloud.pb.h"
#include "hgros/codec/bulk.hpp"
#include "viewer/data/points/point_batch.hpp"

namespace hgros::viewer {

/// Reads a cloud's points: positions of any numeric type, the field `scalar` (empty: intensity or another usual field),
/// and colors if there are any (red, green, blue [, alpha] as bytes, or rgb / rgba in one word). Returns what is wrong
/// with the cloud, or nothing. After an error, `batch` is unchanged.
[[nodiscard]] std::string ReadCloud(const Bulk<foxglove::PointCloud>& cloud, std::string_view scalar,
                                    PointBatch& batch);

}  // namespace hgros::viewer
