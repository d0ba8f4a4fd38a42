#include <gmock/gmock.h>

#include <cmath>

#include "foxglove/VoxelGrid.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using foxglove::VoxelGrid;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kCells = 24;
constexpr double kEdge = 0.3;

/// A ball on a plate, around the origin. Its value grows along x.
VoxelGrid Ball(double radius = 8) {
  VoxelGrid grid;
  grid.set_frame_id("map");
  SetXyz(*grid.mutable_pose()->mutable_position(), -0.5 * kCells * kEdge, -0.5 * kCells * kEdge, 0);
  SetVoxels(grid, kCells, kCells, 4, kEdge);
  AddField(grid, "occupancy", foxglove::PackedElementField::FLOAT32);
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        const double middle = 0.5 * (kCells - 1);
        const bool ball = std::hypot(x - middle, y - middle, z - radius - 1) < radius;
        const float value = z == 0 || ball ? 1 + static_cast<float>(x) : 0.0F;
        grid.mutable_data()->append(reinterpret_cast<const char*>(&value), sizeof value);
      }
    }
  }
  return grid;
}

class VoxelDisplayTest : public SceneTest {};

TEST_F(VoxelDisplayTest, ColorsByHeight) {
  Show("Voxels", "voxels", Ball());
  ExpectAsKept("voxels_by_height");
}

TEST_F(VoxelDisplayTest, ColorsByValueInAnOrthographicView) {
  Show("Voxels", "voxels", Ball(), {"color", "value", "map", "sea"});
  camera_.SetOrthographic(true);
  ExpectAsKept("voxels_by_value");
}

TEST_F(VoxelDisplayTest, DrawsTransparentVoxels) {
  Add("Ground");
  Show("Voxels", "voxels", Ball(6), {"color", "flat", "flat", "#40a0ff", "alpha", "0.3"});
  ExpectAsKept("voxels_see_through");
}

TEST_F(VoxelDisplayTest, DrawsTheFacesTowardTheEyeFromAnywhere) {
  Show("Voxels", "voxels", Ball(), {"color", "flat", "flat", "#ffffff"});
  for (int step = 0; step < 8; ++step) {
    camera_.Orbit(0.8, step % 2 == 0 ? 0.4 : -0.4);
    // The ball is in the middle of the picture, without a hole to the background.
    EXPECT_GT(Draw()[3 * (120 * 320 + 160)], 60) << step;
  }
}

TEST_F(VoxelDisplayTest, LooksTheSameInATurnedFrameMillionsOfMetersAway) {
  const RigidTransform T_map_utm(RigidTransform::Rotation(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())),
                                 {500'000, 5'400'000, 256});
  VoxelGrid there = Ball();
  there.set_frame_id("utm");
  ExpectTheSameFarAway(Ball(), there, T_map_utm, "Voxels", {"color", "value"});
}

TEST_F(VoxelDisplayTest, LeavesNothingOfTheOldGridWhenItIsReplaced) {
  ExpectNothingLeftOf(Ball(8), Ball(5), 0.001, "Voxels", {"color", "value"});
}

TEST_F(VoxelDisplayTest, CountsAllVoxelsAndDrawsNoneInside) {
  Display& display = Show("Voxels", "voxels", Ball());
  EXPECT_THAT(display.Status(), Contains(HasSubstr("voxels are occupied")));
  EXPECT_LT(display.gpu_bytes(), 12U * kCells * kCells * 4);
  VoxelGrid bad = Ball();
  bad.clear_fields();
  Send("voxels", bad);
  EXPECT_TRUE(display.HasFault());
}

TEST_F(VoxelDisplayTest, WaitsAgainForATransformAfterAnEmptyMessage) {
  VoxelGrid empty = Ball();
  empty.set_data(std::string(empty.data().size(), '\0'));
  ExpectItWaitsAgainAfterAnEmptyMessage(Ball(), empty, "Voxels");
}

TEST_F(VoxelDisplayTest, AppliesSettingsWhilePaused) {
  ExpectEffectWhilePaused(Ball(), Ball(3), "Voxels", "threshold", "12");
}

TEST_F(VoxelDisplayTest, ReturnsTheValueOfTheVoxelBehindAFace) {
  Display& display = Show("Voxels", "voxels", Ball());
  const double x = (2.5 - 0.5 * kCells) * kEdge;
  for (const double off : {-1e-4, 0.0, 1e-4}) {
    EXPECT_EQ(display.ValueAt({x, x, kEdge + off}, 0.05), "occupancy = 3") << off;
  }
  EXPECT_EQ(display.ValueAt({x, x, 1.5 * kEdge}, 0.05), "");
  EXPECT_EQ(display.ValueAt({100, 0, 0}, 0.05), "");
}

}  // namespace
}  // namespace hgros::viewer::test
