#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "viewer/data/image/image_reader.hpp"
#include "viewer/data/image/image_value.hpp"

namespace hgros::viewer {
namespace {

using foxglove::CompressedImage;
using foxglove::RawImage;
using ::testing::HasSubstr;
using Bytes4 = std::array<int, 4>;

RawImage Raw(const std::string& encoding, unsigned width, unsigned height, unsigned step, const std::string& data) {
  RawImage image;
  image.set_encoding(encoding);
  image.set_width(width);
  image.set_height(height);
  image.set_step(step);
  image.set_data(data);
  return image;
}

ImagePicture Shown(const RawImage& image, const DepthColors& colors = {}) {
  ImagePicture picture;
  EXPECT_EQ(ReadImage(Bulk<RawImage>(image), colors, picture), "");
  return picture;
}

Bytes4 Pixel(const ImagePicture& picture, std::size_t x, std::size_t y) {
  if (const std::size_t i = y * picture.width + x; i < picture.gray.size()) {
    EXPECT_TRUE(picture.rgba.empty());
    return {picture.gray[i], picture.gray[i], picture.gray[i], 255};
  }
  const std::uint8_t* const at = picture.rgba.data() + 4 * (y * picture.width + x);
  return {at[0], at[1], at[2], at[3]};
}

TEST(ImageReader, ReadsEveryPixelFormat) {
  EXPECT_EQ(Pixel(Shown(Raw("rgb8", 1, 1, 3, "\1\2\3")), 0, 0), (Bytes4{1, 2, 3, 255}));
  EXPECT_EQ(Pixel(Shown(Raw("bgr8", 1, 1, 3, "\1\2\3")), 0, 0), (Bytes4{3, 2, 1, 255}));
  EXPECT_EQ(Pixel(Shown(Raw("rgba8", 1, 1, 4, "\1\2\3\4")), 0, 0), (Bytes4{1, 2, 3, 255}));
  EXPECT_EQ(Pixel(Shown(Raw("bgra8", 1, 1, 4, "\1\2\3\4")), 0, 0), (Bytes4{3, 2, 1, 255}));
  EXPECT_EQ(Pixel(Shown(Raw("bgra8", 1, 1, 4, std::string("\1\2\3\0", 4))), 0, 0), (Bytes4{3, 2, 1, 255}))
      << "many cameras leave alpha 0";
  EXPECT_EQ(Pixel(Shown(Raw("rgb16", 2, 1, 12, ".1.2.3.4.5.6")), 1, 0), (Bytes4{'4', '5', '6', 255}));
  EXPECT_EQ(Pixel(Shown(Raw("mono8", 1, 1, 1, "\7")), 0, 0), (Bytes4{7, 7, 7, 255}));
  EXPECT_EQ(Pixel(Shown(Raw("mono16", 1, 1, 2, "\xff\xff")), 0, 0), (Bytes4{255, 255, 255, 255}));
}

TEST(ImageReader, ReadsRowsWithPadding) {
  const ImagePicture picture = Shown(Raw("mono8", 2, 2, 4, "\1\2..\3\4.."));
  EXPECT_EQ(Pixel(picture, 1, 0)[0], 2);
  EXPECT_EQ(Pixel(picture, 0, 1)[0], 3);
}

TEST(ImageReader, ConvertsYuv) {
  // White, and then red, by BT.601.
  const std::string white = "\xeb\x80\xeb\x80", red = std::string("\x51\x5a\x51\xf0", 4);
  const ImagePicture yuyv = Shown(Raw("yuyv", 4, 1, 8, white + red));
  EXPECT_EQ(Pixel(yuyv, 1, 0), (Bytes4{255, 255, 255, 255}));
  const Bytes4 pixel = Pixel(yuyv, 3, 0);
  EXPECT_NEAR(pixel[0], 255, 2);
  EXPECT_NEAR(pixel[1], 0, 2);
  EXPECT_NEAR(pixel[2], 0, 2);
  const ImagePicture uyvy = Shown(Raw("uyvy", 2, 1, 4, "\x5a\x51\xf0\x51"));
  EXPECT_EQ(Pixel(uyvy, 0, 0), pixel);
  EXPECT_EQ(Shown(Raw("yuv422", 3, 1, 6, "\x80\xeb\x80\xeb\x80\xeb")).rgba.size(), 12U) << "an odd width";
  // Two white pixels above two, beside two red ones above two; the last row and its chroma are white.
  const std::string row = "\xeb\xeb\x51\x51";
  const ImagePicture nv12 =
      Shown(Raw("nv12", 4, 3, 4, row + row + "\xeb\xeb\xeb\xeb" + "\x80\x80\x5a\xf0" + "\x80\x80\x80\x80"));
  EXPECT_EQ(Pixel(nv12, 1, 1), (Bytes4{255, 255, 255, 255}));
  EXPECT_EQ(Pixel(nv12, 3, 1), pixel);
  EXPECT_EQ(Pixel(nv12, 3, 2), (Bytes4{255, 255, 255, 255}));
}

TEST(ImageReader, GivesTheSameColorsForEveryBayerPattern) {
  // A uniform area of red 200, green 100, blue 50.
  for (const std::string square : {"rggb", "bggr", "gbrg", "grbg"}) {
    std::string data;
    for (unsigned y = 0; y < 6; ++y) {
      for (unsigned x = 0; x < 6; ++x) {
        const char part = square[(y % 2) * 2 + x % 2];
        data += static_cast<char>(part == 'r' ? 200 : (part == 'g' ? 100 : 50));
      }
    }
    std::string upper;  // The same with two bytes per pixel.
    for (const char value : data) upper += {'.', value};
    const ImagePicture picture = Shown(Raw("bayer_" + square + "8", 6, 6, 6, data));
    const ImagePicture deep = Shown(Raw("bayer_" + square + "16", 6, 6, 12, upper));
    for (std::size_t y = 0; y < 6; ++y) {
      for (std::size_t x = 0; x < 6; ++x) ASSERT_EQ(Pixel(picture, x, y), (Bytes4{200, 100, 50, 255})) << square;
    }
    EXPECT_EQ(deep.rgba, picture.rgba) << square;
  }
}

TEST(ImageReader, ColorsDepthOverItsRange) {
  const std::string data("\x00\x00\xe8\x03\xd0\x07\xb8\x0b", 8);  // 0, 1000, 2000, 3000
  const ImagePicture picture = Shown(Raw("16UC1", 4, 1, 8, data), {ColorMap::kGray, {}, {}});
  EXPECT_EQ(picture.least, 1000);
  EXPECT_EQ(picture.greatest, 3000);
  EXPECT_EQ(Pixel(picture, 0, 0)[3], 0) << "nothing was measured";
  EXPECT_LT(Pixel(picture, 1, 0)[0], Pixel(picture, 2, 0)[0]);
  EXPECT_LT(Pixel(picture, 2, 0)[0], Pixel(picture, 3, 0)[0]);
  const ImagePicture fixed = Shown(Raw("16UC1", 4, 1, 8, data), {ColorMap::kGray, 0, 1000});
  EXPECT_EQ(Pixel(fixed, 1, 0), Pixel(fixed, 3, 0)) << "values above the range have the last color";
  const std::vector<float> values{1, NAN, INFINITY, 3};
  const ImagePicture floats =
      Shown(Raw("32FC1", 4, 1, 16, std::string(reinterpret_cast<const char*>(values.data()), 16)));
  EXPECT_EQ(floats.greatest, 3);
  EXPECT_EQ(Pixel(floats, 1, 0)[3], 0);
  EXPECT_EQ(Pixel(floats, 2, 0)[3], 0);
}

TEST(ImageReader, SpreadsGray16OverItsRange) {
  const std::string data("\x00\x00\xe8\x03\xd0\x07\xb8\x0b", 8);  // 0, 1000, 2000, 3000
  const ImagePicture own = Shown(Raw("mono16", 4, 1, 8, data));
  EXPECT_EQ(own.least, 0) << "black is measured, too";
  EXPECT_EQ(own.greatest, 3000);
  EXPECT_EQ(Pixel(own, 1, 0)[0], 85);
  const ImagePicture fixed = Shown(Raw("mono16", 4, 1, 8, data), {ColorMap::kRainbow, 1000, 2000});
  EXPECT_EQ(Pixel(fixed, 1, 0)[0], 0);
  EXPECT_EQ(Pixel(fixed, 3, 0)[0], 255);
}

TEST(ImageReader, ReportsInvalidImages) {
  const auto fault = [](const RawImage& image) {
    ImagePicture picture;
    picture.width = 77;
    std::string said = ReadImage(Bulk<RawImage>(image), {}, picture);
    EXPECT_EQ(picture.width, 77U);
    return said;
  };
  EXPECT_THAT(fault(Raw("rgb8", 2, 1, 3, "abc")), HasSubstr("longer than its step"));
  EXPECT_THAT(fault(Raw("rgb8", 1, 2, 3, "abc")), HasSubstr("too few"));
  EXPECT_THAT(fault(Raw("strange", 1, 1, 1, "a")), HasSubstr("\"strange\" is not known"));
  EXPECT_THAT(fault(Raw("mono8", 4'000'000'000, 4'000'000'000, 4'000'000'000, "a")), HasSubstr("too few"));
}

TEST(ImageReader, TakesNeitherMemoryNorTimeForAnImageWithoutPixels) {
  const auto expect_unpainted = [](const RawImage& image) {
    const ImagePicture picture = Shown(image);
    EXPECT_TRUE(picture.rgba.empty() && picture.gray.empty());
    EXPECT_FALSE(picture.least) << image.encoding() << " was painted";
  };
  const auto most_bytes = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss * 1024L;
  };
  const long before = most_bytes();
  expect_unpainted(Raw("16UC1", 2'147'483'647, 0, 4'294'967'294, ""));
  expect_unpainted(Raw("32FC1", 1'000'000'000, 0, 4'000'000'000, ""));
  EXPECT_LT(most_bytes() - before, 1L << 30);
  expect_unpainted(Raw("rgb8", 0, 0, 0, ""));
  expect_unpainted(Raw("bayer_rggb8", 0, 4, 0, ""));
  for (const char* encoding : {"16UC1", "32FC1", "mono8", "mono16", "rgb8", "yuyv", "bayer_rggb8"}) {
    expect_unpainted(Raw(encoding, 0, 4'294'967'295, 0, ""));
  }
}

std::string ReadFile(const std::string& data, ImagePicture& picture) {
  CompressedImage image;
  image.set_format("png");
  image.set_data(data);
  return ReadImage(Bulk<CompressedImage>(image), {}, picture);
}

std::string Png(png_uint_32 format, const void* pixels, png_uint_32 width, png_uint_32 height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  png_alloc_size_t size = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, nullptr), 0);
  std::string file(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, file.data(), &size, 0, pixels, 0, nullptr), 0);
  return file;
}

std::string Jpeg(std::vector<std::uint8_t> rgb, unsigned width, unsigned height) {
  jpeg_compress_struct state{};
  jpeg_error_mgr errors{};
  state.err = jpeg_std_error(&errors);
  jpeg_create_compress(&state);
  unsigned char* to = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&state, &to, &size);
  state.image_width = width;
  state.image_height = height;
  state.input_components = 3;
  state.in_color_space = JCS_RGB;
  jpeg_set_defaults(&state);
  jpeg_set_quality(&state, 95, TRUE);
  jpeg_start_compress(&state, TRUE);
  while (state.next_scanline < height) {
    JSAMPROW row = rgb.data() + static_cast<std::size_t>(state.next_scanline) * width * 3;
    jpeg_write_scanlines(&state, &row, 1);
  }
  jpeg_finish_compress(&state);
  std::string file(reinterpret_cast<const char*>(to), size);
  jpeg_destroy_compress(&state);
  std::free(to);
  return file;
}

std::vector<std::uint8_t> Plain(std::size_t pixels, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  std::vector<std::uint8_t> rgb;
  for (std::size_t i = 0; i < pixels; ++i) rgb.insert(rgb.end(), {r, g, b});
  return rgb;
}

TEST(ImageReader, ReadsPngAndJpegWhateverTheMessageSays) {
  ImagePicture picture;
  ASSERT_EQ(ReadFile(Png(PNG_FORMAT_RGB, Plain(6, 10, 20, 30).data(), 3, 2), picture), "");
  EXPECT_EQ(picture.width, 3U);
  EXPECT_EQ(Pixel(picture, 2, 1), (Bytes4{10, 20, 30, 255}));
  ASSERT_EQ(ReadFile(Jpeg(Plain(64, 200, 100, 50), 8, 8), picture), "") << "although the format says png";
  EXPECT_EQ(picture.height, 8U);
  EXPECT_NEAR(Pixel(picture, 4, 4)[0], 200, 4);
  EXPECT_NEAR(Pixel(picture, 4, 4)[2], 50, 4);
  EXPECT_FALSE(picture.least);
}

TEST(ImageReader, ReadsA16BitGrayPngAsMeasurements) {
  // The simple interface writes linear samples unchanged.
  const std::vector<std::uint16_t> depths{0, 500, 1500, 2500};
  ImagePicture picture;
  ASSERT_EQ(ReadFile(Png(PNG_FORMAT_LINEAR_Y, depths.data(), 2, 2), picture), "");
  EXPECT_EQ(picture.least, 500);
  EXPECT_EQ(picture.greatest, 2500);
  EXPECT_EQ(Pixel(picture, 0, 0)[3], 0);
}

/// Pixels of many colors: a file whose data is longer than its head.
std::vector<std::uint8_t> Noise(std::size_t pixels) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> rgb(3 * pixels);
  for (std::uint8_t& part : rgb) part = static_cast<std::uint8_t>(random());
  return rgb;
}

TEST(ImageReader, ShowsADamagedJpegAndSaysSo) {
  const std::string jpeg = Jpeg(Noise(64 * 64), 64, 64);
  ImagePicture whole;
  ASSERT_EQ(ReadFile(jpeg, whole), "");
  EXPECT_EQ(whole.damage, "");
  ImagePicture half;
  ASSERT_EQ(ReadFile(jpeg.substr(0, jpeg.size() / 2), half), "");
  EXPECT_THAT(half.damage, HasSubstr("The JPEG is damaged: "));
  EXPECT_EQ(half.height, 64U);
  EXPECT_EQ(Pixel(half, 5, 5), Pixel(whole, 5, 5)) << "what is there is shown";
}

TEST(ImageReader, ReportsDamagedFiles) {
  const std::string png = Png(PNG_FORMAT_RGB, Plain(6, 10, 20, 30).data(), 3, 2);
  const std::vector<std::uint16_t> depths{0, 500, 1500, 2500};
  const std::string gray = Png(PNG_FORMAT_LINEAR_Y, depths.data(), 2, 2);
  const std::string jpeg = Jpeg(Plain(64, 200, 100, 50), 8, 8);
  std::mt19937 random(7);
  ImagePicture picture;
  EXPECT_THAT(ReadFile("", picture), HasSubstr("neither PNG nor JPEG"));
  EXPECT_THAT(ReadFile("GIF89a", picture), HasSubstr("neither PNG nor JPEG"));
  for (const std::string& file : {png, gray, jpeg}) {
    for (std::size_t size = 8; size < file.size() - 12; size += 7) {
      EXPECT_NE(ReadFile(file.substr(0, size), picture), "") << "cut to " << size << " bytes";
    }
    for (int i = 0; i < 300; ++i) {
      std::string bent = file;
      for (int k = 0; k < 3; ++k) bent[random() % bent.size()] = static_cast<char>(random());
      (void)ReadFile(bent, picture);  // No crash.
    }
  }
  // A header that announces more pixels than fit into memory.
  std::string huge = png;
  huge[16] = huge[20] = '\x7f';
  EXPECT_NE(ReadFile(huge, picture), "");
}

TEST(ImageValue, IsTheMeasurementOrTheColor) {
  EXPECT_EQ(ColorText({1, 2, 3, 255}), "red 1, green 2, blue 3");
  EXPECT_EQ(ColorText({7, 7, 7, 255}), "7");
  EXPECT_EQ(MeasurementText(1.25F), "1.25");
  EXPECT_EQ(MeasurementText(0), "nothing measured");
  EXPECT_EQ(MeasurementText(std::nanf("")), "nothing measured");
}

TEST(ImageValue, IsReadFromTheMessage) {
  RawImage image = Raw("16UC1", 2, 2, 6, std::string("\1\0\2\0xx\3\0\4\0xx", 12));  // 2 bytes of padding
  EXPECT_EQ(MeasurementAt(Bulk<RawImage>(image), 1, 1), "4");
  EXPECT_EQ(MeasurementAt(Bulk<RawImage>(image), 2, 1), "");
  EXPECT_EQ(MeasurementAt(Bulk<RawImage>(image), 1, 2), "");
  image.set_encoding("mono16");
  EXPECT_EQ(MeasurementAt(Bulk<RawImage>(image), 1, 1), "4");
}

}  // namespace
}  // namespace hgros::viewer
