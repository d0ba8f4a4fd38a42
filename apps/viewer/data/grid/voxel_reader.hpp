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

/// A voxel with at least one visible face.
struct VoxelCube {
  std::array<std::uint32_t, 3> cell;  ///< Column, row, slice.
  std::uint8_t faces = 0;             ///< Faces next to an empty voxel: bits for -x +x -y +y -z +z.
  float value = 0;
};

struct VoxelPicture {
  std::string frame;
  Time stamp;
  Eigen::Isometry3d T_frame_corner =
      Eigen::Isometry3d::Identity();  ///< The corner with the lowest x, y and z, and the axes of the grid.
  Eigen::Vector3d cell_size = Eigen::Vector3d::Zero();  ///< Meters.
  std::array<std::size_t, 3> counts{};                  ///< Columns, rows, slices.
  std::vector<VoxelCube> cubes;
  std::vector<std::string> fields;
  std::string field;
  std::size_t occupied = 0;  ///< Occupied voxels, including those that are not visible.
};

/// A voxel is shown if its field's value is above `threshold`. An empty `field` means the first one. Returns what is
/// wrong, as a sentence, or nothing. After an error, `picture` is unchanged.
[[nodiscard]] std::string ReadVoxels(const Bulk<foxglove::VoxelGrid>& grid, std::string_view field, double threshold,
                                     VoxelPicture& picture);

}  // namespace hgros::viewer
