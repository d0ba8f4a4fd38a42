// Publishes images of several cameras: viewer_cameras [COUNT [WIDTH HEIGHT [ENCODING [SECONDS]]]]. Without a size, each
// camera has another one.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "foxglove/RawImage.pb.h"
#include "hgros/clock/rate.hpp"
#include "hgros/codec/bulk.hpp"
#include "hgros/session/session.hpp"

namespace {

using namespace hgros;
using Image = Bulk<foxglove::RawImage>;

std::size_t PixelBytes(const std::string& encoding) {
  if (encoding == "rgb8") return 3;
  if (encoding == "32FC1") return 4;
  return encoding == "16UC1" || encoding == "mono16" ? 2 : 1;
}

/// A slope that moves with each step.
std::unique_ptr<Image> ImageAt(std::size_t step, std::size_t camera, std::size_t width, std::size_t height,
                               const std::string& encoding) {
  const std::size_t row = width * PixelBytes(encoding);
  auto image = std::make_unique<Image>(row * height);
  foxglove::RawImage& head = image->head();
  head.set_frame_id("camera_" + std::to_string(camera));
  head.set_width(static_cast<std::uint32_t>(width));
  head.set_height(static_cast<std::uint32_t>(height));
  head.set_step(static_cast<std::uint32_t>(row));
  head.set_encoding(encoding);
  // Each row is a part of one long row, a little further than the row above.
  const std::size_t pixel = PixelBytes(encoding);
  std::string longest(row + height / 4 * pixel, '\0');
  for (std::size_t i = 0; i < longest.size(); ++i) {
    const std::size_t value = 255 * i / longest.size() + 10 * step + 60 * camera * (i % pixel);
    longest[i] = static_cast<char>(encoding == "32FC1" && i % pixel == 3 ? 63 : value % 256);
  }
  const auto bytes = image->writable();
  for (std::size_t y = 0; y < height; ++y) std::memcpy(&bytes[y * row], &longest[y / 4 * pixel], row);
  return image;
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int at, std::size_t otherwise) {
    return argc > at ? static_cast<std::size_t>(std::atol(argv[at])) : otherwise;
  };
  const std::size_t count = number(1, 4);
  const std::string encoding = argc > 4 ? argv[4] : "rgb8";
  constexpr std::pair<std::size_t, std::size_t> kSizes[] = {{640, 480}, {1280, 720}, {1242, 375}, {480, 640}};
  Session session;
  std::vector<Publisher<Image>> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    cameras.push_back(session.Advertise<Image>("camera_" + std::to_string(i)));
  }
  Rate rate(session.clock(), std::chrono::milliseconds(500));
  for (std::size_t step = 0; step < 2 * number(5, 60); ++step) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto [width, height] = kSizes[i % std::size(kSizes)];
      cameras[i](ImageAt(step, i, number(2, width), number(3, height), encoding));
    }
    (void)rate.Sleep();
  }
  return 0;
}
