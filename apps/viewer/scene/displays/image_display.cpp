#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <utility>

#include "viewer/data/image/image_reader.hpp"
#include "viewer/data/image/image_value.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/newest_message.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/texture_pixel.hpp"

namespace hgros::viewer {
namespace {

template <class Message>
std::string ReadImagePicture(const Message& image, const DepthColors& colors, ImagePicture& picture) {
  return ReadImage(image, colors, picture);
}

/// The measurement at a pixel as text; empty if there are only colors.
std::string Measured(const Bulk<foxglove::RawImage>& image, const ImagePicture& /*picture*/, std::size_t x,
                     std::size_t y) {
  return MeasurementAt(image, x, y);
}
std::string Measured(const Bulk<foxglove::CompressedImage>& /*image*/, const ImagePicture& picture, std::size_t x,
                     std::size_t y) {
  return picture.values.empty() ? std::string() : MeasurementText(picture.values[y * picture.width + x]);
}

/// The newest image of a channel, for a panel. Its pixels are only on the GPU; its measurements are in the message.
template <class Message>
class ImageDisplay : public Display {
 public:
  explicit ImageDisplay(const DisplayInputs& inputs) : newest_(inputs, DepthColors(), ReadImagePicture<Message>) {}

  [[nodiscard]] Change Update(const UpdateContext& /*context*/) override {
    if (std::exchange(colors_changed_, false)) newest_.SetOptions(Colors());
    return Show(newest_.Take());
  }
  [[nodiscard]] Change ApplySettings(const UpdateContext& /*context*/) override {
    if (!std::exchange(colors_changed_, false)) return Change::kNothing;
    newest_.SetOptions(Colors());
    return Show(newest_.TakeAgain());
  }
  void Clear() override {
    newest_.Clear();
    shown_.reset();
    picture_ = {};
  }
  [[nodiscard]] std::optional<ShownImage> Image() const override {
    if (!shown_ || picture_.width * picture_.height == 0) return std::nullopt;
    return ShownImage{&picture_, texture_.name()};
  }
  [[nodiscard]] std::string PixelText(std::size_t x, std::size_t y) const override {
    if (!shown_ || x >= picture_.width || y >= picture_.height) return {};
    std::string measured = Measured(*shown_, picture_, x, y);
    if (!measured.empty()) return measured;
    std::array<std::uint8_t, 4> pixel = TexturePixel(texture_.name(), x, y);
    if (gray_) pixel[1] = pixel[2] = pixel[0];
    return ColorText(pixel);
  }

  [[nodiscard]] std::optional<ColorLegend> Legend() const override {
    if (!shown_ || !picture_.least || !picture_.greatest) return std::nullopt;
    return ColorLegend{picture_.encoding, gray_ ? ColorMap::kGray : static_cast<ColorMap>(map_), *picture_.least,
                       *picture_.greatest};
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    const auto measured = [this] { return picture_.least.has_value(); };
    const auto colored = [this, measured] { return measured() && !gray_; };
    const auto ranged = [this, measured] { return measured() && !auto_range_; };
    return {
        {"map", "The color map of measurements, from the lowest to the highest.",
         Setting::Choice{&map_, {kColorMapNames.begin(), kColorMapNames.end()}}, colored},
        {"auto range", "The colors go from the lowest to the highest value of each image.",
         Setting::Switch{&auto_range_}, measured},
        {"lowest",
         "The value of the first color, in the image's unit.",
         Setting::Number{&lo_, -1e9F, 1e9F, ""},
         ranged,
         {{"auto range", {"off"}}}},
        {"highest",
         "The value of the last color, in the image's unit.",
         Setting::Number{&hi_, -1e9F, 1e9F, ""},
         ranged,
         {{"auto range", {"off"}}}},
    };
  }
  void OnSetting(const std::string& /*name*/) override { colors_changed_ = true; }

  [[nodiscard]] std::vector<std::string> Status() const override {
    std::vector<std::string> lines;
    if (!fault_.empty()) lines.push_back(fault_);
    if (newest_.received() == 0) {
      lines.emplace_back("Nothing has arrived yet.");
    } else if (picture_.width * picture_.height == 0) {
      if (fault_.empty()) lines.emplace_back("The last image has no pixels.");
    } else {
      lines.push_back(std::to_string(picture_.width) + " x " + std::to_string(picture_.height) + " pixels, " +
                      picture_.encoding);
      if (picture_.least && picture_.greatest) {
        lines.push_back("The colors go from " + Number(*picture_.least) + " to " + Number(*picture_.greatest) + ".");
      }
    }
    if (newest_.dropped() > 0) lines.push_back(Counted(newest_.dropped(), "image", "images") + " arrived too fast.");
    return lines;
  }
  [[nodiscard]] bool HasFault() const override { return !fault_.empty(); }
  [[nodiscard]] std::string data_frame() const override { return picture_.frame; }
  [[nodiscard]] std::uint64_t received() const override { return newest_.received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return newest_.dropped(); }
  [[nodiscard]] std::size_t gpu_bytes() const override { return (gray_ ? 1 : 4) * width_ * height_; }

 private:
  using Newest = NewestMessage<Message, DepthColors, ImagePicture>;

  [[nodiscard]] Change Show(std::optional<typename Newest::Read> read) {
    if (!read) return Change::kNothing;
    fault_ = std::move(read->fault);
    if (fault_.empty()) {
      picture_ = std::move(read->shown);
      shown_ = std::move(read->message);
      fault_ = picture_.damage;
      Upload();
      picture_.rgba = std::vector<std::uint8_t>();  // {} would keep the memory.
      picture_.gray = std::vector<std::uint8_t>();
    }
    return Change::kMoving;
  }

  [[nodiscard]] static std::string Number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
  }

  [[nodiscard]] DepthColors Colors() const {
    DepthColors colors{static_cast<ColorMap>(map_), {}, {}};
    if (!auto_range_) {
      colors.least = static_cast<double>(lo_);
      colors.greatest = static_cast<double>(hi_);
    }
    return colors;
  }

  void Upload() {
    const bool gray = !picture_.gray.empty();
    const std::vector<std::uint8_t>& pixels = gray ? picture_.gray : picture_.rgba;
    if (pixels.empty()) return;
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (std::max(picture_.width, picture_.height) > static_cast<std::size_t>(most)) {
      fault_ =
          "The image has more than " + std::to_string(most) + " pixels along a side, more than this driver supports.";
      picture_ = {};
      shown_.reset();
      return;
    }
    if (!texture_) texture_ = GlTexture::New();
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, texture_.name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, gray ? 1 : 4);
    const GLenum format = gray ? GL_RED : GL_RGBA;
    if (picture_.width != width_ || picture_.height != height_ || gray != gray_) {
      width_ = picture_.width;
      height_ = picture_.height;
      gray_ = gray;
      glTexImage2D(GL_TEXTURE_2D, 0, gray ? GL_R8 : GL_RGBA8, static_cast<GLsizei>(width_),
                   static_cast<GLsizei>(height_), 0, format, GL_UNSIGNED_BYTE, pixels.data());
      constexpr std::array<GLint, 4> kColors{GL_RED, GL_GREEN, GL_BLUE, GL_ALPHA};
      constexpr std::array<GLint, 4> kGray{GL_RED, GL_RED, GL_RED, GL_ONE};
      glTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_SWIZZLE_RGBA, (gray ? kGray : kColors).data());
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    } else {
      glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), format,
                      GL_UNSIGNED_BYTE, pixels.data());
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  }

  std::shared_ptr<const Message> shown_;  ///< The message of the picture; null: there is none.
  ImagePicture picture_;
  GlTexture texture_;
  std::size_t width_ = 0, height_ = 0;  ///< Size of the texture.
  bool gray_ = false;                   ///< The texture has one byte per pixel.
  std::string fault_;
  bool colors_changed_ = false;

  int map_ = 0;
  bool auto_range_ = true;
  float lo_ = 0;
  float hi_ = 10'000;

  Newest newest_;
};

}  // namespace

DisplayType ImageDisplayType() {
  return {"Image", {"foxglove.RawImage"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<ImageDisplay<Bulk<foxglove::RawImage>>>(inputs);
          }};
}

DisplayType CompressedImageDisplayType() {
  return {
      "Compressed image", {"foxglove.CompressedImage"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
        return std::make_unique<ImageDisplay<Bulk<foxglove::CompressedImage>>>(inputs);
      }};
}

}  // namespace hgros::viewer
