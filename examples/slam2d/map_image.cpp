#include "map_image.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

#include "replace_file.hpp"

namespace slam2d {
namespace {

constexpr std::uint8_t kUnknown = 205;
constexpr std::uint8_t kFree = 254;
constexpr std::uint32_t kMaxEdgePixels = 1U << 15U;

// Covered cells, both ends included.
struct CellBox {
  int min_x = std::numeric_limits<int>::max();
  int min_y = std::numeric_limits<int>::max();
  int max_x = std::numeric_limits<int>::min();
  int max_y = std::numeric_limits<int>::min();

  void Add(int x, int y) {
    min_x = std::min(min_x, x);
    min_y = std::min(min_y, y);
    max_x = std::max(max_x, x);
    max_y = std::max(max_y, y);
  }
};

int CellX(std::size_t cell) { return static_cast<int>(cell % kTileEdgeCells); }
int CellY(std::size_t cell) { return static_cast<int>(cell / kTileEdgeCells); }

std::uint8_t Gray(int value, const MapOptions& options) {
  if (value == 0) return kUnknown;
  if (value < 0) return static_cast<std::uint8_t>(kUnknown + (kFree - kUnknown) * value / options.min_value);
  // A few hits already make a wall.
  const int full = std::max(1, std::min(options.max_value, 3 * options.hit_gain));
  return static_cast<std::uint8_t>(kUnknown - kUnknown * std::min(value, full) / full);
}

using Rgb = std::array<std::uint8_t, 3>;

class Canvas {
 public:
  Canvas(const CellBox& box, std::uint32_t channels, int edge_pixels) : box_(box) {
    const auto width = static_cast<std::uint32_t>(box.max_x - box.min_x + 1);
    const auto height = static_cast<std::uint32_t>(box.max_y - box.min_y + 1);
    const std::uint32_t edge = std::max(width, height);
    if (edge > kMaxEdgePixels) {
      throw std::runtime_error("The map is over 32768 cells wide or high, too large for an image.");
    }
    scale_ = std::clamp(edge_pixels / static_cast<int>(edge), 1, kMostPixelsPerCell);
    const auto scale = static_cast<std::uint32_t>(scale_);
    image_ = {width * scale, height * scale, channels, {}};
    image_.bytes.assign(std::size_t{image_.width} * image_.height * channels, kUnknown);
  }

  void Cell(int x, int y, const Rgb& rgb) { Square((x - box_.min_x) * scale_, (box_.max_y - y) * scale_, scale_, rgb); }

  // A line between points in cells. Its resolution is finer than cells, and it is half a cell wide.
  void Line(const Point2& from, const Point2& to, const Rgb& rgb) {
    const int pen = (scale_ + 1) / 2;
    const double columns = (to.x - from.x) * scale_;
    const double rows = (to.y - from.y) * scale_;
    const double steps = std::ceil(std::max({1.0, std::abs(columns), std::abs(rows)}));
    for (double i = 0.0; i <= steps; i += 1.0) {
      const double part = i / steps;
      const double column = (from.x - box_.min_x) * scale_ + part * columns;
      const double row = (from.y - box_.min_y) * scale_ + part * rows;
      Square(static_cast<int>(std::floor(column)) - pen / 2,
             static_cast<int>(image_.height) - 1 - static_cast<int>(std::floor(row)) - pen / 2, pen, rgb);
    }
  }

  MapImage Take() { return std::move(image_); }

 private:
  void Square(int left, int top, int edge, const Rgb& rgb) {
    for (int row = top; row < top + edge; ++row) {
      for (int column = left; column < left + edge; ++column) {
        const std::size_t pixel = static_cast<std::size_t>(row) * image_.width + static_cast<std::size_t>(column);
        std::copy_n(rgb.begin(), image_.channels,
                    image_.bytes.begin() + static_cast<std::ptrdiff_t>(pixel * image_.channels));
      }
    }
  }

  CellBox box_;
  int scale_ = 1;  // Pixels per cell edge.
  MapImage image_;
};

std::vector<Point2> InCells(const PathOverlay& overlay, double cell_size_m) {
  std::vector<Point2> points;
  points.reserve(overlay.T_map_laser.size());
  for (const Pose2& pose : overlay.T_map_laser) points.push_back({pose.x / cell_size_m, pose.y / cell_size_m});
  return points;
}

}  // namespace

MapImage RenderMap(const OccupancyMap& map, std::span<const PathOverlay> overlays, int edge_pixels) {
  CellBox box;
  for (const auto& [index, tile] : map.tiles()) {
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      box.Add(index.x * kTileEdgeCells + CellX(cell), index.y * kTileEdgeCells + CellY(cell));
    }
  }
  std::vector<std::vector<Point2>> paths;
  for (const PathOverlay& overlay : overlays) {
    paths.push_back(InCells(overlay, map.options().cell_size_m));
    for (const Point2& p : paths.back()) {
      box.Add(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)));
    }
  }
  if (box.min_x > box.max_x) return {1, 1, 1, {kUnknown}};
  box.Add(box.min_x - 1, box.min_y - 1);
  box.Add(box.max_x + 1, box.max_y + 1);

  Canvas canvas(box, overlays.empty() ? 1 : 3, edge_pixels);
  for (const auto& [index, tile] : map.tiles()) {
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      const std::uint8_t gray = Gray(tile[cell], map.options());
      canvas.Cell(index.x * kTileEdgeCells + CellX(cell), index.y * kTileEdgeCells + CellY(cell), {gray, gray, gray});
    }
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (std::size_t k = 1; k < paths[i].size(); ++k) canvas.Line(paths[i][k - 1], paths[i][k], overlays[i].rgb);
  }
  return canvas.Take();
}

void WritePng(const MapImage& image, const std::filesystem::path& path) {
  ReplaceFile(path, "The map image", [&](const std::filesystem::path& temporary) {
    png_image header{};
    header.version = PNG_IMAGE_VERSION;
    header.width = image.width;
    header.height = image.height;
    header.format = image.channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
    if (png_image_write_to_file(&header, temporary.c_str(), 0, image.bytes.data(), 0, nullptr) == 0) {
      throw std::runtime_error("The map image " + path.string() + " cannot be written: " + header.message + ".");
    }
  });
}

}  // namespace slam2d
