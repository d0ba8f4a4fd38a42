#include "viewer/scene/type_mismatch.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

TEST(TypeMismatchTest, IsExplainedInPlainWords) {
  EXPECT_EQ(WhyNotShown(*DisplayTypeNamed("Grid"), "cloud", "foxglove.PointCloud"),
            "\"cloud\" carries foxglove.PointCloud; a Grid shows foxglove.Grid.");
  EXPECT_EQ(WhyNotShown(*DisplayTypeNamed("Image"), "cloud", "foxglove.PointCloud"),
            "\"cloud\" carries foxglove.PointCloud; an Image shows foxglove.RawImage.");
}

TEST(TypeMismatchTest, IsEmptyIfTheTypeFitsOrIsUnknown) {
  EXPECT_EQ(WhyNotShown(*DisplayTypeNamed("Grid"), "map", "foxglove.Grid"), "");
  EXPECT_EQ(WhyNotShown(*DisplayTypeNamed("Grid"), "map", ""), "");
  EXPECT_EQ(WhyNotShown(*DisplayTypeNamed("Ground"), "", "foxglove.Grid"), "");
}

}  // namespace
}  // namespace hgros::viewer
