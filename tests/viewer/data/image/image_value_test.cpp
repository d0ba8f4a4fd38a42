#include "viewer/data/image/image_value.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hgros::viewer {
namespace {

TEST(ImageValue, IsTheMeasurementOrTheColor) {
  ImagePicture picture;
  picture.width = 3;
  picture.height = 1;
  picture.rgba = {1, 2, 3, 255, 7, 7, 7, 255, 0, 0, 0, 0};
  EXPECT_EQ(ValueAt(picture, 0, 0), "red 1, green 2, blue 3");
  EXPECT_EQ(ValueAt(picture, 1, 0), "7");
  EXPECT_EQ(ValueAt(picture, 0, 1), "");
  picture.values = {1.25F, 0, std::nanf("")};
  EXPECT_EQ(ValueAt(picture, 0, 0), "1.25");
  EXPECT_EQ(ValueAt(picture, 1, 0), "nothing measured");
  EXPECT_EQ(ValueAt(picture, 2, 0), "nothing measured");
}

}  // namespace
}  // namespace hgros::viewer
