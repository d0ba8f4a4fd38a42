#include "viewer/data/image/yuv.hpp"

#include <algorithm>

namespace hgros::viewer {
namespace {

void PaintPixel(int y, int u, int v, std::uint8_t* out) {
  const int c = 298 * (y - 16), d = u - 128, e = v - 128;
  const auto byte = [](int value) { return static_cast<std::uint8_t>(std::clamp(value / 256, 0, 255)); };
  out[0] = byte(c + 409 * e + 128);
  out[1] = byte(c - 100 * d - 208 * e + 128);
  out[2] = byte(c + 516 * d + 128);
  out[3] = 255;
}

}  // namespace

void PaintYuv422(const ImageView& view, YuvOrder order, std::vector<std::uint8_t>& rgba) {
  const std::size_t luma = order == YuvOrder::kYuyv ? 0 : 1;
  const std::size_t chroma = 1 - luma;
  std::uint8_t* out = rgba.data();
  for (std::size_t y = 0; y < view.height(); ++y) {
    const auto* in = reinterpret_cast<const std::uint8_t*>(view.Row(y).data());
    std::size_t x = 0;
    for (; x + 1 < view.width(); x += 2, in += 4, out += 8) {
      PaintPixel(in[luma], in[chroma], in[chroma + 2], out);
      PaintPixel(in[luma + 2], in[chroma], in[chroma + 2], out + 4);
    }
    if (x < view.width()) {
      PaintPixel(in[luma], 128, 128, out);
      out += 4;
    }
  }
}

void PaintNv12(const ImageView& view, std::vector<std::uint8_t>& rgba) {
  std::uint8_t* out = rgba.data();
  for (std::size_t y = 0; y < view.height(); ++y) {
    const auto* luma = reinterpret_cast<const std::uint8_t*>(view.Row(y).data());
    const auto* chroma = reinterpret_cast<const std::uint8_t*>(view.ChromaRow(y).data());
    for (std::size_t x = 0; x < view.width(); ++x, out += 4) {
      PaintPixel(luma[x], chroma[x - x % 2], chroma[x - x % 2 + 1], out);
    }
  }
}

}  // namespace hgros::viewer
