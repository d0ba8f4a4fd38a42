#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "foxglove/Grid.pb.h"
#include "hgros/clock/time.hpp"
#include "hgros/codec/bulk.hpp"
#include "viewer/data/grid/grid_palette.hpp"

namespace hgros::viewer {

/// A grid as a picture in the world.
struct GridPicture {
  std::string frame;
  Time stamp;
  Eigen::Isometry3d T_frame_corner =
      Eigen::Isometry3d::Identity();  ///< The corner with the lowest x and y, and the axes of the grid.
  Eigen::Vector2d cell_size = Eigen::Vector2d::Zero();  ///< Meters.
  std::size_t columns = 0, rows = 0;
  std::vector<Rgba> pixels;  ///< Row by row, starting at the corner.
  std::vector<std::string> fields;
  std::string field;     ///< The field that is shown.
  bool colored = false;  ///< The grid's own red, green and blue are used instead of the palette.
};

/// Reads the field of that name. Empty: reads red, green and blue if they exist, or else the first field. The default
/// palette is kMap for bytes and kRaw otherwise. Returns what is wrong, as a sentence, or nothing. After an error,
/// `picture` is unchanged.
[[nodiscard]] std::string ReadGrid(const Bulk<foxglove::Grid>& grid, std::string_view field,
                                   std::optional<GridPalette> palette, GridPicture& picture);

}  // namespace hgros::viewer
