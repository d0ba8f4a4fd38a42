#include "map_image.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <stdexcept>

#include "support/scratch_folder.hpp"

namespace slam2d {
namespace {

const std::vector<PathOverlay> kPaths{{{{0.2, -0.3, 0.0}, {0.2, 0.4, 0.0}}, kCorrectedRgb}};

OccupancyMap OneBeamMap() {
  OccupancyMap map;
  LaserScan2 scan;
  scan.max_range_m = 50.0;
  scan.ranges_m = {1.02F};
  for (int i = 0; i < 12; ++i) map.Integrate(scan, {0.025, 0.025, 0.0});
  return map;
}

MapImage ReadPng(const std::filesystem::path& path, std::uint32_t channels) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  EXPECT_EQ((header.format & PNG_FORMAT_FLAG_COLOR) != 0, channels == 3);
  header.format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  MapImage image{header.width, header.height, channels, {}};
  image.bytes.resize(PNG_IMAGE_SIZE(header));
  EXPECT_NE(png_image_finish_read(&header, nullptr, image.bytes.data(), 0, nullptr), 0) << header.message;
  return image;
}

TEST(MapImage, DrawsFreeWhiteOccupiedBlackAndUnknownGray) {
  const MapImage image = RenderMap(OneBeamMap());
  // 20 free cells and the wall, with one unknown cell around.
  ASSERT_EQ(image.width, 23U);
  ASSERT_EQ(image.height, 3U);
  ASSERT_EQ(image.channels, 1U);
  EXPECT_EQ(image.bytes[23 + 0], 205);
  EXPECT_EQ(image.bytes[23 + 1], 254);
  EXPECT_EQ(image.bytes[23 + 20], 254);
  EXPECT_EQ(image.bytes[23 + 21], 0);
  EXPECT_EQ(image.bytes[5], 205);
}

TEST(MapImage, LibpngReadsTheSamePixelsBack) {
  const hgros::test::ScratchFolder folder;
  const OccupancyMap map = OneBeamMap();
  const MapImage gray = RenderMap(map);
  const MapImage color = RenderMap(map, kPaths);
  ASSERT_EQ(color.channels, 3U);
  EXPECT_GT(color.height, gray.height) << "the path leaves the map";
  for (const MapImage& image : {gray, color}) {
    WritePng(image, folder / "map.png");
    const MapImage read = ReadPng(folder / "map.png", image.channels);
    EXPECT_EQ(read.width, image.width);
    EXPECT_EQ(read.height, image.height);
    EXPECT_EQ(read.bytes, image.bytes);
    EXPECT_FALSE(std::filesystem::exists(folder / "map.png.part"));
  }
  // y = 0.4 lies in cell 8: one below the top row, in the fifth column of the map.
  EXPECT_EQ(color.bytes[(color.width + 5) * 3 + 0], kCorrectedRgb[0]);
  EXPECT_EQ(color.bytes[(color.width + 5) * 3 + 2], kCorrectedRgb[2]);
}

TEST(MapImage, CellsGetAsManyPixelsAsTheEdgeAllows) {
  const MapImage cells = RenderMap(OneBeamMap());
  const MapImage larger = RenderMap(OneBeamMap(), {}, 3 * 23 + 5);
  ASSERT_EQ(larger.width, 3 * cells.width);
  ASSERT_EQ(larger.height, 3 * cells.height);
  for (std::uint32_t row = 0; row < larger.height; ++row) {
    for (std::uint32_t column = 0; column < larger.width; ++column) {
      ASSERT_EQ(larger.bytes[row * larger.width + column], cells.bytes[row / 3 * cells.width + column / 3]);
    }
  }
  EXPECT_EQ(RenderMap(OneBeamMap(), {}, 1000).width, kMostPixelsPerCell * cells.width);
  EXPECT_EQ(RenderMap(OneBeamMap(), {}, 10).width, cells.width);
}

TEST(MapImage, DrawsPathsFinerThanCellsIfACellHasSeveralPixels) {
  const MapImage image = RenderMap(OneBeamMap(), kPaths, 1000);
  std::size_t blue = 0;
  for (std::size_t i = 0; i < image.bytes.size(); i += 3) blue += image.bytes[i] == kCorrectedRgb[0] ? 1 : 0;
  // From cell -6 to cell 8, four pixels a cell, two wide, and the ends.
  EXPECT_GE(blue, 14U * 4 * 2);
  EXPECT_LE(blue, 15U * 4 * 2);
}

TEST(MapImage, OfAnEmptyMapIsOneUnknownPixel) {
  const MapImage image = RenderMap(OccupancyMap());
  EXPECT_EQ(image.width * image.height, 1U);
  EXPECT_EQ(image.bytes.at(0), 205);
}

TEST(MapImage, ThrowsASentenceIfItCannotBeWritten) {
  const hgros::test::ScratchFolder folder;
  try {
    WritePng(RenderMap(OccupancyMap()), folder / "missing/map.png");
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("cannot be written"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace slam2d
