#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "foxglove/VoxelGrid.pb.h"
#include "hgros/clock/time.hpp"
#include "hgros/codec/bulk.hpp"

namespace hgros::viewer {

/// A voxel of which something can be seen.
struct VoxelCube {
  std::array<std::uint32_t, 3> cell;  ///< Column, row, slice.
  std::uint8_t faces = 0;             ///< Those that border on an empty voxel: bits for -x +x -y +y -z +z.
  float value = 0;
};

struct VoxelPicture {
  std::string frame;
  Time stamp;
  Eigen::Isometry3d T_frame_corner = Eigen::Isometry3d::Identity();  ///< Of least x, y and z, with the axes.
  Eigen::Vector3d cell_size = Eigen::Vector3d::Zero();               ///< Metres.
  std::array<std::size_t, 3> counts{};                               ///< Columns, rows, slices.
  std::vector<VoxelCube> cubes;
  std::vector<std::string> fields;
  std::string field;
  std::size_t occupied = 0;  ///< Voxels with something in them, those inside included.
};

/// A voxel is shown if its field's value is above `threshold`. `field` empty: the first one. Returns what is wrong, in
/// a sentence, or nothing; then `picture` is what it was before.
[[nodiscard]] std::string ReadVoxels(const Bulk<foxglove::VoxelGrid>& grid, std::string_view field, double threshold,
                                     VoxelPicture& picture);

}  // namespace hgros::viewer
