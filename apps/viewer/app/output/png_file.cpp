#include "viewer/app/output/png_file.hpp"

#include <png.h>

#include <system_error>

namespace hgros::viewer {

std::string WritePng(const std::filesystem::path& file, const Viewport& size, std::span<const std::uint8_t> rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(size.width);
  image.height = static_cast<png_uint_32>(size.height);
  image.format = PNG_FORMAT_RGB;
  std::filesystem::path unfinished = file;
  unfinished += ".unfinished";
  if (png_image_write_to_file(&image, unfinished.c_str(), 0, rgb.data(), 0, nullptr) == 0) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    return file.string() + " cannot be written: " + image.message + ".";
  }
  std::error_code fault;
  std::filesystem::rename(unfinished, file, fault);
  return fault ? file.string() + " cannot be written: " + fault.message() + "." : std::string();
}

}  // namespace hgros::viewer
