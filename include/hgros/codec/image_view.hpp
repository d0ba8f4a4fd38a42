#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/bulk.hpp"
#include "hgros/codec/packed_elements.hpp"
#include "hgros/codec/strided_view.hpp"
#include "hgros/codec/view_result.hpp"

namespace hgros {

/// The rows of an uncompressed image in place, from top to bottom. Borrows the bytes.
/// Thread safety: as a value; reading is const.
class HGROS_EXPORT ImageView {
 public:
  /// The description of an image in a message. Sizes in pixels; `step_bytes` is the distance between rows.
  struct Shape {
    std::uint64_t width = 0;
    std::uint64_t height = 0;
    std::uint64_t step_bytes = 0;
    std::string encoding;  ///< "mono8", "rgb8", "16UC1", "32FC1" ...: the open foxglove names.
  };
  /// Errors: an unknown encoding, rows longer than the step, fewer bytes than step times height (nv12: 3/2 of it).
  [[nodiscard]] static ViewResult<ImageView> Of(Bytes data, Shape shape);

  [[nodiscard]] std::size_t width() const noexcept { return static_cast<std::size_t>(shape_.width); }
  [[nodiscard]] std::size_t height() const noexcept { return static_cast<std::size_t>(shape_.height); }
  [[nodiscard]] std::size_t step_bytes() const noexcept { return static_cast<std::size_t>(shape_.step_bytes); }
  [[nodiscard]] const std::string& encoding() const noexcept { return shape_.encoding; }
  /// Samples per pixel: 1 for gray and Bayer images and nv12, 2 for yuyv, 3 for rgb8, 4 for rgba8.
  [[nodiscard]] std::size_t channels() const noexcept { return channels_; }

  /// The pixels of row `y` (below height()) without padding: width() times the bytes of a pixel.
  [[nodiscard]] Bytes Row(std::size_t y) const noexcept { return data_.subspan(y * step_bytes(), row_bytes_); }
  /// Only of nv12, whose Row() has brightness: U and V of each two pixels of row `y`. Two rows share one of these.
  [[nodiscard]] Bytes ChromaRow(std::size_t y) const noexcept {
    return data_.subspan((height() + y / 2) * step_bytes(), width() + width() % 2);
  }

  /// The samples of the rows as numbers of type T, which must be the encoding's type.
  template <class T>
  class Samples {
   public:
    Samples(Bytes data, std::size_t step_bytes, std::size_t row_samples) noexcept
        : data_(data), step_(step_bytes), row_samples_(row_samples) {}
    /// Row `y` (below height()): width() times channels() samples, pixel by pixel.
    [[nodiscard]] StridedView<T> operator[](std::size_t y) const noexcept {
      return {data_.data() + y * step_, sizeof(T), row_samples_};
    }

   private:
    Bytes data_;
    std::size_t step_;
    std::size_t row_samples_;
  };
  /// Errors: the encoding stores samples of another type.
  template <class T>
  [[nodiscard]] ViewResult<Samples<T>> SamplesAs() const {
    static_assert(NumericTypeOf<T>() != NumericType::kUnknown, "A sample is std::uint8_t, std::uint16_t or float.");
    std::string fault = Mismatch(NumericTypeOf<T>());
    if (!fault.empty()) return ViewResult<Samples<T>>::Fault(std::move(fault));
    return Samples<T>(data_, step_bytes(), row_bytes_ / sizeof(T));
  }

 private:
  ImageView() = default;
  [[nodiscard]] std::string Mismatch(NumericType type) const;

  Bytes data_;
  Shape shape_;
  NumericType sample_ = NumericType::kUnknown;
  std::size_t channels_ = 0;
  std::size_t row_bytes_ = 0;
};

/// foxglove::RawImage, or any type with its fields.
template <class T>
concept RawImageMessage = ProtobufMessage<T> && requires(const T& image) {
  image.width();
  image.height();
  image.step();
  image.encoding();
  image.data();
};

/// The image of a message, which may be a Bulk. The view borrows the message.
///
///     const auto image = hgros::ViewImage(message);         // each of the two: a view, or a fault()
///     const auto samples = image->SamplesAs<std::uint8_t>();
///     const std::uint8_t green = (*samples)[y][3 * x + 1];  // of rgb8
template <RawImageMessage T>
[[nodiscard]] ViewResult<ImageView> ViewImage(const T& image) {
  return ImageView::Of(AsBytes(image.data()), {image.width(), image.height(), image.step(), image.encoding()});
}
template <RawImageMessage T>
[[nodiscard]] ViewResult<ImageView> ViewImage(const Bulk<T>& image) {
  const T& head = image.head();
  return ImageView::Of(image.bytes(), {head.width(), head.height(), head.step(), head.encoding()});
}
/// Deleted: a view of a temporary message would dangle.
template <class T>
void ViewImage(const T&& image) = delete;

}  // namespace hgros
