#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "occupancy_map.hpp"
#include "pose2.hpp"

namespace slam2d {

/// A line through poses, drawn over a map.
struct PathOverlay {
  std::vector<Pose2> T_map_laser;
  std::array<std::uint8_t, 3> rgb{};
};

inline constexpr std::array<std::uint8_t, 3> kCorrectedRgb{30, 90, 220};  ///< Blue.
inline constexpr std::array<std::uint8_t, 3> kOdometryRgb{220, 40, 30};   ///< Red.

inline constexpr int kMostPixelsPerCell = 4;
inline constexpr int kScreenEdgePixels = 1600;  ///< Fits on a screen.

/// An image with `channels` bytes per pixel (1 gray, 3 RGB), top row first.
struct MapImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 1;
  std::vector<std::uint8_t> bytes;
};

/// Free is white, occupied black, unknown light gray (205), and other cells in between. y points up. A border of one
/// unknown cell surrounds the map. With overlays the image is RGB, otherwise gray. Paths that leave the map widen the
/// image. An empty map gives one unknown pixel. A cell is a square of 1 to kMostPixelsPerCell pixels a side: as many as
/// keep the longer edge of the image within `edge_pixels`.
///
/// Errors: throws std::runtime_error if the map is over 32768 cells wide or high.
[[nodiscard]] MapImage RenderMap(const OccupancyMap& map, std::span<const PathOverlay> overlays = {},
                                 int edge_pixels = 0);

/// Writes a PNG under a temporary name beside `path`, then renames it, so that a reader never sees a partial image.
///
/// Errors: throws std::runtime_error with a sentence; `path` is then unchanged.
void WritePng(const MapImage& image, const std::filesystem::path& path);

}  // namespace slam2d
