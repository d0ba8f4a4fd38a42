#include "viewer/data/image/depth_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hgros::viewer {
namespace {

bool IsMeasured(float value) { return std::isfinite(value) && value != 0; }

}  // namespace

void PaintDepth(const DepthColors& colors, const ReadDepthRow& read, ImagePicture& picture) {
  std::vector<float> row(picture.width);
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for (std::size_t y = 0; y < picture.height; ++y) {
    read(y, row);
    for (const float value : row) {
      if (!IsMeasured(value)) continue;
      least = std::min<double>(least, value);
      greatest = std::max<double>(greatest, value);
    }
  }
  if (least > greatest) least = greatest = 0;
  least = colors.least.value_or(least);
  greatest = colors.greatest.value_or(greatest);
  picture.least = least;
  picture.greatest = greatest;

  static const std::vector<std::uint8_t> table = ColorMapTable();
  const std::uint8_t* const map = table.data() + static_cast<std::size_t>(colors.map) * kColorMapSteps * 3;
  picture.rgba.resize(4 * picture.width * picture.height);
  std::uint8_t* out = picture.rgba.data();
  for (std::size_t y = 0; y < picture.height; ++y) {
    read(y, row);
    for (const float value : row) {
      if (IsMeasured(value)) {
        const double part = greatest > least ? std::clamp((value - least) / (greatest - least), 0.0, 1.0) : 0.5;
        const auto step = static_cast<std::size_t>(std::lround(part * (kColorMapSteps - 1)));
        std::copy_n(map + 3 * step, 3, out);
        out[3] = 255;
      } else {
        std::fill_n(out, 4, std::uint8_t{0});
      }
      out += 4;
    }
  }
}

}  // namespace hgros::viewer
