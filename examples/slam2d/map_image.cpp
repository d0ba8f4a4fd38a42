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

// Cells covered, both ends included.
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
  // A few hits already are a wall.
  const int full = std::max(1, std::min(options.max_value, 3 * options.hit_gain));
  return static_cast<std::uint8_t>(kUnknown - kUnknown * std::min(value, full) / full);
}

class Canvas {
 public:
  Canvas(const CellBox& box, std::uint32_t channels) : box_(box) {
    const auto width = static_cast<std::uint32_t>(box.max_x - box.min_x + 1);
    const auto height = static_cast<std::uint32_t>(box.max_y - box.min_y + 1);
    if (width > kMaxEdgePixels || height > kMaxEdgePixels) {
      throw std::runtime_error("The map is over 32768 cells wide or high, too large for an image.");
    }
    image_ = {width, height, channels, {}};
    image_.bytes.assign(std::size_t{width} * height * channels, kUnknown);
  }

  void Set(int x, int y, const std::array<std::uint8_t, 3>& rgb) {
    const auto row = static_cast<std::size_t>(box_.max_y - y);
    const std::size_t pixel = row * image_.width + static_cast<std::size_t>(x - box_.min_x);
    std::copy_n(rgb.begin(), image_.channels,
                image_.bytes.begin() + static_cast<std::ptrdiff_t>(pixel * image_.channels));
  }

  void Line(const Point2& from, const Point2& to, const std::array<std::uint8_t, 3>& rgb) {
    const double steps = std::ceil(std::max({1.0, std::abs(to.x - from.x), std::abs(to.y - from.y)}));
    for (double i = 0.0; i <= steps; i += 1.0) {
      const double part = i / steps;
      Set(static_cast<int>(std::floor(from.x + part * (to.x - from.x))),
          static_cast<int>(std::floor(from.y + part * (to.y - from.y))), rgb);
    }
  }

  MapImage Take() { return std::move(image_); }

 private:
  CellBox box_;
  MapImage image_;
};

std::vector<Point2> InCells(const PathOverlay& overlay, double cell_size_m) {
  std::vector<Point2> points;
  points.reserve(overlay.T_map_laser.size());
  for (const Pose2& pose : overlay.T_map_laser) points.push_back({pose.x / cell_size_m, pose.y / cell_size_m});
  return points;
}

}  // namespace

MapImage RenderMap(const OccupancyMap& map, std::span<const PathOverlay> overlays) {
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

  Canvas canvas(box, overlays.empty() ? 1 : 3);
  for (const auto& [index, tile] : map.tiles()) {
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      const std::uint8_t gray = Gray(tile[cell], map.options());
      canvas.Set(index.x * kTileEdgeCells + CellX(cell), index.y * kTileEdgeCells + CellY(cell), {gray, gray, gray});
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
