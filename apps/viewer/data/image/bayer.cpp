#include "viewer/data/image/bayer.hpp"

#include <algorithm>

namespace hgros::viewer {

std::optional<BayerPattern> BayerPatternOf(std::string_view encoding) {
  const std::string_view order = encoding.substr(0, encoding.find_last_not_of("0123456789") + 1);
  if (order == "bayer_rggb") return BayerPattern{0, 1, 1, 2};
  if (order == "bayer_bggr") return BayerPattern{2, 1, 1, 0};
  if (order == "bayer_gbrg") return BayerPattern{1, 2, 0, 1};
  if (order == "bayer_grbg") return BayerPattern{1, 0, 2, 1};
  return std::nullopt;
}

void PaintBayer(const ImageView& view, const BayerPattern& pattern, std::vector<std::uint8_t>& rgba) {
  const std::size_t sample_bytes = view.Row(0).size() / view.width();  // The last byte of a sample is the upper one.
  const auto part_at = [&](std::size_t x, std::size_t y) { return pattern[(y % 2) * 2 + x % 2]; };
  std::uint8_t* out = rgba.data();
  for (std::size_t y = 0; y < view.height(); ++y) {
    const std::size_t top = y == 0 ? 0 : y - 1, bottom = std::min(y + 1, view.height() - 1);
    for (std::size_t x = 0; x < view.width(); ++x, out += 4) {
      const std::size_t left = x == 0 ? 0 : x - 1, right = std::min(x + 1, view.width() - 1);
      std::array<unsigned, 3> sum{}, count{};
      for (std::size_t j = top; j <= bottom; ++j) {
        const auto* row = reinterpret_cast<const std::uint8_t*>(view.Row(j).data());
        for (std::size_t i = left; i <= right; ++i) {
          const std::uint8_t part = part_at(i, j);
          // A pixel's own color channel is what it has measured.
          if (part == part_at(x, y) && (i != x || j != y)) continue;
          sum[part] += row[(i + 1) * sample_bytes - 1];
          ++count[part];
        }
      }
      for (std::size_t part = 0; part < 3; ++part) {
        out[part] = static_cast<std::uint8_t>(count[part] == 0 ? 0 : sum[part] / count[part]);
      }
      out[3] = 255;
    }
  }
}

}  // namespace hgros::viewer
