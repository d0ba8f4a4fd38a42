#include "hgros/codec/image_view.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace hgros {
namespace {

struct PixelForm {
  std::string_view encoding;
  NumericType sample;
  std::size_t sample_bytes;
  std::size_t channels;
};

// The encodings that the open schema foxglove.RawImage names, and others that cameras have.
constexpr std::array kPixelForms{
    PixelForm{"mono8", NumericType::kUint8, 1, 1},         PixelForm{"8UC1", NumericType::kUint8, 1, 1},
    PixelForm{"8UC3", NumericType::kUint8, 1, 3},          PixelForm{"rgb8", NumericType::kUint8, 1, 3},
    PixelForm{"bgr8", NumericType::kUint8, 1, 3},          PixelForm{"rgba8", NumericType::kUint8, 1, 4},
    PixelForm{"bgra8", NumericType::kUint8, 1, 4},         PixelForm{"bayer_rggb8", NumericType::kUint8, 1, 1},
    PixelForm{"bayer_bggr8", NumericType::kUint8, 1, 1},   PixelForm{"bayer_gbrg8", NumericType::kUint8, 1, 1},
    PixelForm{"bayer_grbg8", NumericType::kUint8, 1, 1},   PixelForm{"yuyv", NumericType::kUint8, 1, 2},
    PixelForm{"yuv422_yuy2", NumericType::kUint8, 1, 2},   PixelForm{"uyvy", NumericType::kUint8, 1, 2},
    PixelForm{"yuv422", NumericType::kUint8, 1, 2},        PixelForm{"mono16", NumericType::kUint16, 2, 1},
    PixelForm{"16UC1", NumericType::kUint16, 2, 1},        PixelForm{"32FC1", NumericType::kFloat32, 4, 1},
    PixelForm{"bayer_rggb16", NumericType::kUint16, 2, 1}, PixelForm{"bayer_bggr16", NumericType::kUint16, 2, 1},
    PixelForm{"bayer_gbrg16", NumericType::kUint16, 2, 1}, PixelForm{"bayer_grbg16", NumericType::kUint16, 2, 1},
    PixelForm{"rgb16", NumericType::kUint16, 2, 3},        PixelForm{"nv12", NumericType::kUint8, 1, 1},
};

std::string SampleName(NumericType type) {
  switch (type) {
    case NumericType::kUint8: return "std::uint8_t";
    case NumericType::kUint16: return "std::uint16_t";
    case NumericType::kFloat32: return "float";
    default: return "another type";
  }
}

}  // namespace

ViewResult<ImageView> ImageView::Of(Bytes data, Shape shape) {
  const auto fault = [](std::string sentence) { return ViewResult<ImageView>::Fault(std::move(sentence)); };
  const auto form = std::ranges::find(kPixelForms, shape.encoding, &PixelForm::encoding);
  if (form == kPixelForms.end()) return fault("The encoding \"" + shape.encoding + "\" is not known.");
  // Divides, because a product could overflow.
  const std::size_t pixel_bytes = form->sample_bytes * form->channels;
  const bool has_chroma = shape.encoding == "nv12";
  const std::uint64_t odd = has_chroma ? shape.width % 2 : 0;
  if (shape.width > (shape.step_bytes - std::min(odd, shape.step_bytes)) / pixel_bytes) {
    return fault("A row of " + std::to_string(shape.width) + " pixels of " + std::to_string(pixel_bytes) +
                 " bytes is longer than its step, " + std::to_string(shape.step_bytes) + " bytes.");
  }
  const std::uint64_t chroma_rows = has_chroma ? shape.height / 2 + shape.height % 2 : 0;
  if (shape.height > 0 && (shape.step_bytes > data.size() / shape.height ||
                           chroma_rows * shape.step_bytes > data.size() - shape.height * shape.step_bytes)) {
    return fault(std::to_string(data.size()) + " bytes are too few for " + std::to_string(shape.height) + " rows of " +
                 std::to_string(shape.step_bytes) + " bytes" + (has_chroma ? " and half as many of chroma." : "."));
  }
  ImageView image;
  image.data_ = data;
  image.sample_ = form->sample;
  image.channels_ = form->channels;
  image.row_bytes_ = static_cast<std::size_t>(shape.width) * pixel_bytes;
  image.shape_ = std::move(shape);
  return image;
}

std::string ImageView::Mismatch(NumericType type) const {
  if (type == sample_) return {};
  return "Samples of encoding \"" + shape_.encoding + "\" are " + SampleName(sample_) + ", not " + SampleName(type) +
         ".";
}

}  // namespace hgros
