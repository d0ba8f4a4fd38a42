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
#include "viewer/data/grid_palette.hpp"

namespace hgros::viewer {

/// A grid as a picture that lies in the world.
struct GridPicture {
  std::string frame;
  Time stamp;
  Eigen::Isometry3d T_frame_corner = Eigen::Isometry3d::Identity();  ///< The corner of least x and y, with the axes.
  Eigen::Vector2d cell_size = Eigen::Vector2d::Zero();               ///< Metres.
  std::size_t columns = 0, rows = 0;
  std::vector<Rgba> pixels;  ///< Row by row from the corner.
  std::vector<std::string> fields;
  std::string field;     ///< The one that is shown.
  bool colored = false;  ///< By the grid's own red, green, blue; the palette was not used.
};

/// Reads the field of that name; if it is empty: red, green and blue where they are, or else the first field. With no
/// palette given, one that suits: kMap for bytes, kRaw otherwise. Returns what is wrong, in a sentence, or nothing;
/// then `picture` is what it was before.
[[nodiscard]] std::string ReadGrid(const Bulk<foxglove::Grid>& grid, std::string_view field,
                                   std::optional<GridPalette> palette, GridPicture& picture);

}  // namespace hgros::viewer
