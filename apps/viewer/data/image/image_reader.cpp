#include "viewer/data/image/image_reader.hpp"

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

// Offsets of the colors in a pixel. In gray images all three are the same.
struct Parts {
  std::size_t red, green, blue;
  int alpha = -1;
};

void PaintParts(const ImageView& view, const Parts& parts, std::vector<std::uint8_t>& rgba) {
  std::uint8_t* out = rgba.data();
  for (std::size_t y = 0; y < view.height(); ++y) {
    const auto* in = reinterpret_cast<const std::uint8_t*>(view.Row(y).data());
    for (std::size_t x = 0; x < view.width(); ++x, in += view.channels(), out += 4) {
      out[0] = in[parts.red];
      out[1] = in[parts.green];
      out[2] = in[parts.blue];
      out[3] = parts.alpha < 0 ? 255 : in[parts.alpha];
    }
  }
}

template <class T>
std::vector<float> ValuesOf(const ImageView& view) {
  std::vector<float> values;
  values.reserve(view.width() * view.height());
  const auto samples = view.SamplesAs<T>();
  for (std::size_t y = 0; samples && y < view.height(); ++y) {
    for (const T value : (*samples)[y]) values.push_back(static_cast<float>(value));
  }
  return values;
}

void PaintGray16(const ImageView& view, std::vector<std::uint8_t>& rgba) {
  const auto values = ValuesOf<std::uint16_t>(view);
  std::uint8_t* out = rgba.data();
  for (const float value : values) {
    out[0] = out[1] = out[2] = static_cast<std::uint8_t>(value / 257);
    out[3] = 255;
    out += 4;
  }
}

// Returns false if the encoding is unknown here.
bool Paint(const ImageView& view, const DepthColors& colors, ImagePicture& picture) {
  const std::string& encoding = view.encoding();
  auto& rgba = picture.rgba;
  if (encoding == "rgb8" || encoding == "8UC3") {
    PaintParts(view, {0, 1, 2}, rgba);
  } else if (encoding == "bgr8") {
    PaintParts(view, {2, 1, 0}, rgba);
  } else if (encoding == "rgba8") {
    PaintParts(view, {0, 1, 2, 3}, rgba);
  } else if (encoding == "bgra8") {
    PaintParts(view, {2, 1, 0, 3}, rgba);
  } else if (encoding == "mono8" || encoding == "8UC1") {
    PaintParts(view, {0, 0, 0}, rgba);
  } else if (encoding == "mono16") {
    PaintGray16(view, rgba);
  } else if (encoding == "16UC1") {
    picture.values = ValuesOf<std::uint16_t>(view);
    PaintDepth(colors, picture);
  } else if (encoding == "32FC1") {
    picture.values = ValuesOf<float>(view);
    PaintDepth(colors, picture);
  } else if (encoding == "yuyv" || encoding == "yuv422_yuy2") {
    PaintYuv422(view, YuvOrder::kYuyv, rgba);
  } else if (encoding == "uyvy" || encoding == "yuv422") {
    PaintYuv422(view, YuvOrder::kUyvy, rgba);
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
  if (view->height() > 0 && view->width() > kMaxImagePixels / view->height()) {
    return "The image has more than " + std::to_string(kMaxImagePixels) + " pixels.";
  }
  ImagePicture read;
  read.frame = image.head().frame_id();
  read.stamp = StampOf(image.head().timestamp());
  read.width = view->width();
  read.height = view->height();
  read.encoding = view->encoding();
  read.rgba.resize(read.width * read.height * 4);
  if (!Paint(*view, colors, read)) return "The encoding \"" + view->encoding() + "\" cannot be shown.";
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
