#include "viewer/data/image/image_value.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hgros::viewer {
namespace {

TEST(ImageValue, IsTheMeasurementOrTheColor) {
  EXPECT_EQ(ColorText({1, 2, 3, 255}), "red 1, green 2, blue 3");
  EXPECT_EQ(ColorText({7, 7, 7, 255}), "7");
  EXPECT_EQ(MeasurementText(1.25F), "1.25");
  EXPECT_EQ(MeasurementText(0), "nothing measured");
  EXPECT_EQ(MeasurementText(std::nanf("")), "nothing measured");
}

TEST(ImageValue, IsReadFromTheMessage) {
  foxglove::RawImage image;
  image.set_encoding("16UC1");
  image.set_width(2);
  image.set_height(2);
  image.set_step(6);  // 2 bytes of padding
  image.set_data(std::string("\1\0\2\0xx\3\0\4\0xx", 12));
  EXPECT_EQ(MeasurementAt(Bulk<foxglove::RawImage>(image), 1, 1), "4");
  EXPECT_EQ(MeasurementAt(Bulk<foxglove::RawImage>(image), 2, 1), "");
  EXPECT_EQ(MeasurementAt(Bulk<foxglove::RawImage>(image), 1, 2), "");
  image.set_encoding("mono16");
  EXPECT_EQ(MeasurementAt(Bulk<foxglove::RawImage>(image), 1, 1), "") << "it has brightness, not measurements";
}

}  // namespace
}  // namespace hgros::viewer
