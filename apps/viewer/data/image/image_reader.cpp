#include "viewer/data/image/image_reader.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "hgros/codec/image_view.hpp"
#include "viewer/data/image/bayer.hpp"
#include "viewer/data/image/depth_picture.hpp"
#include "viewer/data/image/image_file.hpp"
#include "viewer/data/image/yuv.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMaxImagePixels = 256UL << 20;

// Offsets of the colors in a pixel, in bytes. Of samples with two bytes, the upper ones are shown. Alpha is ignored:
// many cameras leave it 0.
struct Parts {
  std::size_t red, green, blue;
};

void PaintParts(const ImageView& view, const Parts& parts, std::vector<std::uint8_t>& rgba) {
  std::uint8_t* out = rgba.data();
  const std::size_t pixel_bytes = view.Row(0).size() / view.width();
  for (std::size_t y = 0; y < view.height(); ++y) {
    const auto* in = reinterpret_cast<const std::uint8_t*>(view.Row(y).data());
    for (std::size_t x = 0; x < view.width(); ++x, in += pixel_bytes, out += 4) {
      out[0] = in[parts.red];
      out[1] = in[parts.green];
      out[2] = in[parts.blue];
      out[3] = 255;
    }
  }
}

void PaintGray8(const ImageView& view, std::vector<std::uint8_t>& gray) {
  std::uint8_t* out = gray.data();
  for (std::size_t y = 0; y < view.height(); ++y, out += view.width()) {
    std::memcpy(out, view.Row(y).data(), view.width());
  }
}

// Black to white over the range of the colors, or else over that of the image. If all are equal, the upper bytes.
void PaintGray16(const ImageView& view, const DepthColors& colors, ImagePicture& picture) {
  const auto samples = view.SamplesAs<std::uint16_t>();
  if (!samples) return;
  std::uint16_t lowest = 0xFFFF, highest = 0;
  for (std::size_t y = 0; y < view.height(); ++y) {
    for (const std::uint16_t value : (*samples)[y]) {
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
  }
  picture.least = colors.least.value_or(lowest);
  picture.greatest = colors.greatest.value_or(highest);
  const bool spread = *picture.greatest > *picture.least;
  const double shift = spread ? *picture.least : 0;
  const double scale = 255 / (spread ? *picture.greatest - *picture.least : 65535);
  std::uint8_t* out = picture.gray.data();
  for (std::size_t y = 0; y < view.height(); ++y) {
    for (const std::uint16_t value : (*samples)[y]) {
      *out++ = static_cast<std::uint8_t>(std::clamp((value - shift) * scale + 0.5, 0.0, 255.0));
    }
  }
}

template <class T>
void PaintMeasured(const ImageView& view, const DepthColors& colors, ImagePicture& picture) {
  const auto samples = view.SamplesAs<T>();
  PaintDepth(
      colors,
      [&](std::size_t y, std::span<float> row) {
        std::size_t x = 0;
        for (const T value : (*samples)[y]) row[x++] = static_cast<float>(value);
      },
      picture);
}

// The view has pixels. Returns false if the encoding is unknown here.
bool Paint(const ImageView& view, const DepthColors& colors, ImagePicture& picture) {
  const std::string& encoding = view.encoding();
  auto& rgba = picture.rgba;
  const std::size_t pixels = view.width() * view.height();
  if (encoding == "mono8" || encoding == "8UC1") {
    picture.gray.resize(pixels);
    PaintGray8(view, picture.gray);
    return true;
  }
  if (encoding == "mono16") {
    picture.gray.resize(pixels);
    PaintGray16(view, colors, picture);
    return true;
  }
  if (encoding == "16UC1") {
    PaintMeasured<std::uint16_t>(view, colors, picture);
    return true;
  }
  if (encoding == "32FC1") {
    PaintMeasured<float>(view, colors, picture);
    return true;
  }
  rgba.resize(4 * pixels);
  if (encoding == "rgb8" || encoding == "8UC3" || encoding == "rgba8") {
    PaintParts(view, {0, 1, 2}, rgba);
  } else if (encoding == "rgb16") {
    PaintParts(view, {1, 3, 5}, rgba);
  } else if (encoding == "bgr8" || encoding == "bgra8") {
    PaintParts(view, {2, 1, 0}, rgba);
  } else if (encoding == "yuyv" || encoding == "yuv422_yuy2") {
    PaintYuv422(view, YuvOrder::kYuyv, rgba);
  } else if (encoding == "uyvy" || encoding == "yuv422") {
    PaintYuv422(view, YuvOrder::kUyvy, rgba);
  } else if (encoding == "nv12") {
    PaintNv12(view, rgba);
  } else if (const auto pattern = BayerPatternOf(encoding)) {
    PaintBayer(view, *pattern, rgba);
  } else {
    return false;
  }
  return true;
}

}  // namespace

std::string ReadImage(const Bulk<foxglove::RawImage>& image, const DepthColors& colors, ImagePicture& picture) {
  const auto view = ViewImage(image);
  if (!view) return view.fault();
  // Without pixels, the sizes may be any numbers: no data stands behind them.
  const bool has_pixels = view->width() > 0 && view->height() > 0;
  if (has_pixels && view->width() > kMaxImagePixels / view->height()) {
    return "The image has more than " + std::to_string(kMaxImagePixels) + " pixels.";
  }
  ImagePicture read;
  read.frame = image.head().frame_id();
  read.stamp = StampOf(image.head().timestamp());
  read.width = view->width();
  read.height = view->height();
  read.encoding = view->encoding();
  if (has_pixels && !Paint(*view, colors, read)) return "The encoding \"" + view->encoding() + "\" cannot be shown.";
  picture = std::move(read);
  return {};
}

std::string ReadImage(const Bulk<foxglove::CompressedImage>& image, const DepthColors& colors, ImagePicture& picture) {
  ImagePicture read;
  read.frame = image.head().frame_id();
  read.stamp = StampOf(image.head().timestamp());
  read.encoding = image.head().format();
  if (std::string fault = ReadImageFile(image.bytes(), colors, read); !fault.empty()) return fault;
  picture = std::move(read);
  return {};
}

}  // namespace hgros::viewer
