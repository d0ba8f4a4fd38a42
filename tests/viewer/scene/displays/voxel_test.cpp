#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "foxglove/VoxelGrid.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using foxglove::PackedElementField;
using foxglove::VoxelGrid;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kCells = 24;
constexpr double kEdge = 0.3;

/// A ball on a plate, around the origin. Its value grows along x.
VoxelGrid Ball(double radius = 8) {
  VoxelGrid grid;
  grid.set_frame_id("map");
  grid.mutable_pose()->mutable_position()->set_x(-0.5 * kCells * kEdge);
  grid.mutable_pose()->mutable_position()->set_y(-0.5 * kCells * kEdge);
  grid.set_column_count(kCells);
  grid.set_row_count(kCells);
  SetXyz(*grid.mutable_cell_size(), kEdge, kEdge, kEdge);
  grid.set_cell_stride(4);
  grid.set_row_stride(4 * kCells);
  grid.set_slice_stride(4 * kCells * kCells);
  auto* const field = grid.add_fields();
  field->set_name("occupancy");
  field->set_type(PackedElementField::FLOAT32);
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
  Add("Voxels", "voxels");
  Publish("voxels", Ball());
  Update();
  ExpectAsKept("voxels_by_height");
}

TEST_F(VoxelDisplayTest, ColorsByValueInAnOrthographicView) {
  Add("Voxels", "voxels", {"color", "value", "map", "sea"});
  Publish("voxels", Ball());
  Update();
  camera_.SetOrthographic(true);
  ExpectAsKept("voxels_by_value");
}

TEST_F(VoxelDisplayTest, DrawsTransparentVoxels) {
  Add("Ground");
  Add("Voxels", "voxels", {"color", "flat", "flat", "#40a0ff", "alpha", "0.3"});
  Publish("voxels", Ball(6));
  Update();
  ExpectAsKept("voxels_see_through");
}

TEST_F(VoxelDisplayTest, DrawsTheFacesTowardTheEyeFromAnywhere) {
  Add("Voxels", "voxels", {"color", "flat", "flat", "#ffffff"});
  Publish("voxels", Ball());
  Update();
  for (int step = 0; step < 8; ++step) {
    camera_.Orbit(0.8, step % 2 == 0 ? 0.4 : -0.4);
    const Pixels pixels = Draw();
    // The ball is in the middle of the picture, without a hole to the background.
    const std::size_t middle = 3 * (120 * 320 + 160);
    EXPECT_GT(pixels[middle], 60) << step;
  }
}

TEST_F(VoxelDisplayTest, LooksTheSameInATurnedFrameMillionsOfMetersAway) {
  Add("Voxels", "voxels", {"color", "value"});
  Publish("voxels", Ball());
  Update(0);
  const Pixels here = Draw();
  const RigidTransform T_map_utm(RigidTransform::Rotation(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())),
                                 {500'000, 5'400'000, 256});
  tree_.SetStatic("map", "utm", T_map_utm);
  transforms_changed_ = true;
  VoxelGrid grid = Ball();
  grid.set_frame_id("utm");
  Publish("voxels", grid);
  Update(1);
  camera_.Follow(RigidTransform(), T_map_utm, true);
  EXPECT_LT(DifferentShare(here, Draw()), 0.01);
}

TEST_F(VoxelDisplayTest, LeavesNothingOfTheOldGridWhenItIsReplaced) {
  Add("Voxels", "voxels", {"color", "value"});
  Publish("voxels", Ball(8));
  Update(0);
  (void)Draw();
  Publish("voxels", Ball(5));
  Update(1);
  const Pixels rewritten = Draw();
  Update(10);
  const Pixels settled = Draw();
  scene_.Remove(0);
  Add("Voxels", "voxels", {"color", "value"});
  Publish("voxels", Ball(5));
  Update(11);
  const Pixels fresh = Draw();
  EXPECT_LT(DifferentShare(rewritten, fresh), 0.001);
  EXPECT_LT(DifferentShare(settled, fresh), 0.001);
}

TEST_F(VoxelDisplayTest, CountsAllVoxelsAndDrawsNoneInside) {
  Display& display = Add("Voxels", "voxels");
  Publish("voxels", Ball());
  Update();
  EXPECT_THAT(display.Status(), Contains(HasSubstr("voxels are occupied")));
  EXPECT_LT(display.gpu_bytes(), 12U * kCells * kCells * 4);
  VoxelGrid bad = Ball();
  bad.clear_fields();
  Publish("voxels", bad);
  Update();
  EXPECT_TRUE(display.HasFault());
}

TEST_F(VoxelDisplayTest, WaitsAgainForATransformAfterAnEmptyMessage) {
  Display& display = Add("Voxels", "voxels");
  tree_.SetStatic("map", "other", RigidTransform());
  VoxelGrid full = Ball();
  full.set_frame_id("lidar");
  Publish("voxels", full);
  Update(0);
  Update(2);
  EXPECT_TRUE(display.HasFault());
  VoxelGrid empty = full;
  empty.set_data(std::string(full.data().size(), '\0'));
  Publish("voxels", empty);
  Update(3);
  EXPECT_FALSE(display.HasFault()) << display.Status().front();
  Publish("voxels", full);
  Update(10);
  EXPECT_FALSE(display.HasFault()) << "the transform may still come";
  EXPECT_THAT(display.WaitsFor(), HasSubstr("lidar"));
  Update(12);
  EXPECT_TRUE(display.HasFault());
}

TEST_F(VoxelDisplayTest, AppliesSettingsWhilePaused) {
  Display& display = Add("Voxels", "voxels");
  Publish("voxels", Ball());
  Update();
  Publish("voxels", Ball(3));
  SetStandingStill(display, "threshold", "12");
  const Pixels standing = Draw();
  scene_.Remove(0);
  Add("Voxels", "fresh", {"threshold", "12"});
  Publish("fresh", Ball());
  Update();
  EXPECT_EQ(DifferentShare(standing, Draw()), 0);
}

TEST_F(VoxelDisplayTest, ReturnsTheValueOfTheVoxelBehindAFace) {
  Display& display = Add("Voxels", "voxels");
  Publish("voxels", Ball());
  Update();
  const double plate_top = kEdge;
  const double x = (2.5 - 0.5 * kCells) * kEdge;
  for (const double off : {-1e-4, 0.0, 1e-4}) {
    EXPECT_EQ(display.ValueAt({x, x, plate_top + off}, 0.05), "occupancy = 3") << off;
  }
  EXPECT_EQ(display.ValueAt({x, x, plate_top + 0.5 * kEdge}, 0.05), "");
  EXPECT_EQ(display.ValueAt({100, 0, 0}, 0.05), "");
}

}  // namespace
}  // namespace hgros::viewer::test
