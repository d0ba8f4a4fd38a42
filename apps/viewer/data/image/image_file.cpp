#include "viewer/data/image/image_file.hpp"

// clang-format off
#include <jpeglib.h>
#include <jerror.h>  // Its numbers depend on the header above.
// clang-format on
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include "viewer/data/image/depth_picture.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMaxFilePixels = 64UL << 20;

bool BeginsWith(Bytes file, std::span<const std::uint8_t> magic) {
  return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
}

std::string TooLarge(std::size_t width, std::size_t height) {
  if (width > 0 && height > 0 && width <= kMaxFilePixels / height) return {};
  return "The image has " + std::to_string(width) + " x " + std::to_string(height) + " pixels, which cannot be shown.";
}

// libpng's simple interface: always 8 bits per sample.
std::string ReadPng(Bytes file, ImagePicture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto failed = [&image] {
    std::string said = "The PNG cannot be read: " + std::string(image.message) + ".";
    png_image_free(&image);
    return said;
  };
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) return failed();
  if (std::string fault = TooLarge(image.width, image.height); !fault.empty()) {
    png_image_free(&image);
    return fault;
  }
  image.format = PNG_FORMAT_RGBA;
  picture.width = image.width;
  picture.height = image.height;
  picture.rgba.resize(picture.width * picture.height * 4);
  if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr) == 0) return failed();
  return {};
}

// Width, height, bit depth and color type are at fixed places after the signature.
bool IsGray16(Bytes file) {
  constexpr std::size_t kBitDepth = 24, kColorType = 25;
  return file.size() > kColorType && file[kBitDepth] == std::byte{16} && file[kColorType] == std::byte{0};
}

/// Reads 16-bit samples unchanged, which the simple interface does not do.
class Gray16 {
 public:
  Gray16() : png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, OnError, OnWarning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  Gray16(const Gray16&) = delete;
  Gray16& operator=(const Gray16&) = delete;
  ~Gray16() { png_destroy_read_struct(&png_, &info_, nullptr); }

  // No object with a destructor may be made between setjmp and the calls that jump there.
  [[nodiscard]] std::string Read(Bytes file, ImagePicture& picture, std::vector<float>& values) {
    rest_ = file;
    if (png_ == nullptr || info_ == nullptr) return "There is not enough memory for the PNG.";
    if (setjmp(jump_) != 0) return "The PNG cannot be read: " + std::string(message_.data()) + ".";
    png_set_read_fn(png_, this, OnRead);
    png_read_info(png_, info_);
    picture.width = png_get_image_width(png_, info_);
    picture.height = png_get_image_height(png_, info_);
    if (picture.width > kMaxFilePixels / std::max<std::size_t>(picture.height, 1))
      return TooLarge(picture.width, picture.height);
    png_set_swap(png_);
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    samples_.resize(picture.width * picture.height);
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t y = 0; y < picture.height; ++y) {
        png_read_row(png_, reinterpret_cast<png_bytep>(samples_.data() + y * picture.width), nullptr);
      }
    }
    values.assign(samples_.begin(), samples_.end());
    return {};
  }

 private:
  static Gray16& Self(png_structp png) { return *static_cast<Gray16*>(png_get_error_ptr(png)); }
  [[noreturn]] static void OnError(png_structp png, png_const_charp message) {
    Gray16& self = Self(png);
    std::snprintf(self.message_.data(), self.message_.size(), "%s", message);
    longjmp(self.jump_, 1);  // NOLINT: libpng's way; it must not be thrown through.
  }
  static void OnWarning(png_structp /*png*/, png_const_charp /*message*/) {}
  static void OnRead(png_structp png, png_bytep to, std::size_t size) {
    Gray16& self = *static_cast<Gray16*>(png_get_io_ptr(png));
    if (size > self.rest_.size()) png_error(png, "the file ends too early");
    std::memcpy(to, self.rest_.data(), size);
    self.rest_ = self.rest_.subspan(size);
  }

  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  Bytes rest_;
  std::jmp_buf jump_{};
  std::array<char, 200> message_{};
  std::vector<std::uint16_t> samples_;
};

/// libjpeg reports errors by a jump.
class Jpeg {
 public:
  Jpeg() {
    state_.err = jpeg_std_error(&errors_);
    errors_.error_exit = OnError;
    errors_.emit_message = [](j_common_ptr state, int level) {
      // Many cameras write some bytes more than they need.
      if (level < 0 && state->err->msg_code != JWRN_EXTRANEOUS_DATA) Keep(state);
    };
    state_.client_data = this;
  }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;
  ~Jpeg() {
    if (made_) jpeg_destroy_decompress(&state_);
  }

  // No object with a destructor may be made between setjmp and the calls that jump there.
  [[nodiscard]] std::string Read(Bytes file, ImagePicture& picture) {
    if (setjmp(jump_) != 0) {
      if (state_.output_scanline == 0) return "The JPEG cannot be read: " + std::string(message_.data()) + ".";
      RecordDamage(picture);
      return {};
    }
    jpeg_create_decompress(&state_);
    made_ = true;
    jpeg_mem_src(&state_, reinterpret_cast<const unsigned char*>(file.data()), file.size());
    jpeg_read_header(&state_, TRUE);
    picture.width = state_.image_width;
    picture.height = state_.image_height;
    if (picture.width > kMaxFilePixels / std::max<std::size_t>(picture.height, 1))
      return TooLarge(picture.width, picture.height);
    state_.out_color_space = JCS_EXT_RGBA;
    jpeg_start_decompress(&state_);
    picture.rgba.resize(picture.width * picture.height * 4);
    while (state_.output_scanline < state_.output_height) {
      JSAMPROW row = picture.rgba.data() + static_cast<std::size_t>(state_.output_scanline) * picture.width * 4;
      jpeg_read_scanlines(&state_, &row, 1);
    }
    jpeg_finish_decompress(&state_);
    if (message_[0] != '\0') RecordDamage(picture);
    return {};
  }

 private:
  void RecordDamage(ImagePicture& picture) const {
    picture.damage = "The JPEG is damaged: " + std::string(message_.data()) + ".";
  }
  /// Keeps the last message of libjpeg.
  static Jpeg& Keep(j_common_ptr state) {
    Jpeg& self = *static_cast<Jpeg*>(state->client_data);
    std::array<char, JMSG_LENGTH_MAX> said{};
    state->err->format_message(state, said.data());
    std::snprintf(self.message_.data(), self.message_.size(), "%.150s", said.data());
    return self;
  }
  [[noreturn]] static void OnError(j_common_ptr state) {
    Jpeg& self = Keep(state);
    longjmp(self.jump_, 1);  // NOLINT: libjpeg's way; it must not be thrown through.
  }

  jpeg_decompress_struct state_{};
  jpeg_error_mgr errors_{};
  bool made_ = false;
  std::jmp_buf jump_{};
  std::array<char, 200> message_{};
};

}  // namespace

std::string ReadImageFile(Bytes file, const DepthColors& colors, ImagePicture& picture) {
  constexpr std::array<std::uint8_t, 8> kPng{0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
  constexpr std::array<std::uint8_t, 3> kJpeg{0xff, 0xd8, 0xff};
  if (BeginsWith(file, kJpeg)) return Jpeg().Read(file, picture);
  if (!BeginsWith(file, kPng)) {
    return "The image is neither PNG nor JPEG" +
           (picture.encoding.empty() ? std::string() : "; the message calls it \"" + picture.encoding + "\"") + ".";
  }
  if (!IsGray16(file)) return ReadPng(file, picture);
  if (std::string fault = Gray16().Read(file, picture, picture.values); !fault.empty()) return fault;
  const auto row = [&](std::size_t y, std::span<float> values) {
    std::copy_n(picture.values.data() + y * picture.width, picture.width, values.data());
  };
  PaintDepth(colors, row, picture);
  return {};
}

}  // namespace hgros::viewer
