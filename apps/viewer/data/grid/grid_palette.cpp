#include "viewer/data/grid/grid_palette.hpp"

#include <algorithm>
#include <cmath>

namespace hgros::viewer {
namespace {

constexpr Rgba kUnknown = MakeRgba(112, 137, 134);
constexpr double kOccupied = 100;

}  // namespace

Rgba ColorOfCell(GridPalette palette, double value) {
  if (value > 127 && value <= 255) value -= 256;
  if (!(value >= 0 && value <= kOccupied)) return kUnknown;
  const double part = value / kOccupied;
  if (palette == GridPalette::kMap) {
    const auto gray = static_cast<unsigned>(std::lround(255 * (1 - part)));
    return MakeRgba(gray, gray, gray);
  }
  if (value == 0) return MakeRgba(0, 0, 0, 0);
  if (value == 99) return MakeRgba(0, 255, 255);
  if (value == kOccupied) return MakeRgba(255, 0, 255);
  const auto red = static_cast<unsigned>(std::lround(255 * part));
  return MakeRgba(red, 0, 255 - red);
}

Rgba GrayOfCell(double value, double least, double greatest) {
  if (!std::isfinite(value)) return MakeRgba(0, 0, 0, 0);
  const double part = greatest > least ? std::clamp((value - least) / (greatest - least), 0.0, 1.0) : 1.0;
  const auto gray = static_cast<unsigned>(std::lround(255 * part));
  return MakeRgba(gray, gray, gray);
}

}  // namespace hgros::viewer
