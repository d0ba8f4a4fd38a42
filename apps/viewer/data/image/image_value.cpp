#include "viewer/data/image/image_value.hpp"

#include <cmath>
#include <cstdio>

#include "hgros/codec/image_view.hpp"

namespace hgros::viewer {

std::string MeasurementText(float value) {
  if (!std::isfinite(value) || value == 0) return "nothing measured";
  char text[64];
  std::snprintf(text, sizeof text, "%.6g", static_cast<double>(value));
  return text;
}

std::string ColorText(const std::array<std::uint8_t, 4>& rgba) {
  if (rgba[0] == rgba[1] && rgba[1] == rgba[2]) return std::to_string(rgba[0]);
  char text[64];
  std::snprintf(text, sizeof text, "red %d, green %d, blue %d", rgba[0], rgba[1], rgba[2]);
  return text;
}

std::string MeasurementAt(const Bulk<foxglove::RawImage>& image, std::size_t x, std::size_t y) {
  const auto view = ViewImage(image);
  if (!view || x >= view->width() || y >= view->height()) return {};
  const bool mono16 = view->encoding() == "mono16";
  if (mono16 || view->encoding() == "16UC1") {
    const auto samples = view->SamplesAs<std::uint16_t>();
    if (!samples) return {};
    return mono16 ? std::to_string((*samples)[y][x]) : MeasurementText((*samples)[y][x]);
  }
  if (view->encoding() == "32FC1") {
    const auto samples = view->SamplesAs<float>();
    return samples ? MeasurementText((*samples)[y][x]) : std::string();
  }
  return {};
}

}  // namespace hgros::viewer
