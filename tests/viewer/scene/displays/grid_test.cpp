#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "foxglove/Grid.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "viewer/scene/layers/picture_tiles.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using foxglove::PackedElementField;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kColumns = 48;
constexpr int kRows = 36;
constexpr double kCell = 0.25;

/// Cells around the origin, without values.
foxglove::Grid Empty(PackedElementField::NumericType type, std::uint32_t bytes) {
  foxglove::Grid grid;
  grid.set_frame_id("map");
  grid.mutable_pose()->mutable_position()->set_x(-0.5 * kColumns * kCell);
  grid.mutable_pose()->mutable_position()->set_y(-0.5 * kRows * kCell);
  grid.mutable_cell_size()->set_x(kCell);
  grid.mutable_cell_size()->set_y(kCell);
  grid.set_column_count(kColumns);
  grid.set_cell_stride(bytes);
  grid.set_row_stride(kColumns * bytes);
  auto* const field = grid.add_fields();
  field->set_name("value");
  field->set_type(type);
  return grid;
}

/// Two rooms with a door between them. The area to the right of them is unknown.
foxglove::Grid Rooms(int door = 10) {
  foxglove::Grid grid = Empty(PackedElementField::INT8, 1);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const bool wall = x == 0 || y == 0 || y == kRows - 1 || x == 38 || (x == 20 && std::abs(y - door) > 3);
      grid.mutable_data()->push_back(x > 38 ? char{-1} : wall ? char{100} : char{0});
    }
  }
  return grid;
}

/// Costs that decrease around one place, and are 0 far away.
foxglove::Grid Costs() {
  foxglove::Grid grid = Empty(PackedElementField::INT8, 1);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      grid.mutable_data()->push_back(static_cast<char>(std::max(0.0, 100 - 8 * std::hypot(x - 28, y - 12))));
    }
  }
  return grid;
}

foxglove::Grid Heights() {
  foxglove::Grid grid = Empty(PackedElementField::FLOAT32, 4);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const auto height = static_cast<float>(std::sin(0.3 * x) + std::cos(0.25 * y));
      grid.mutable_data()->append(reinterpret_cast<const char*>(&height), sizeof height);
    }
  }
  return grid;
}

/// A line of points on the ground, from one corner to the other.
foxglove::PointCloud Diagonal() {
  foxglove::PointCloud cloud;
  cloud.set_frame_id("map");
  cloud.set_point_stride(12);
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    auto* const field = cloud.add_fields();
    field->set_name(name);
    field->set_type(PackedElementField::FLOAT32);
    field->set_offset(offset);
    offset += 4;
  }
  for (int i = 0; i < 200; ++i) {
    const float at[3] = {0.05F * static_cast<float>(i) - 5, 0.04F * static_cast<float>(i) - 4, 0};
    cloud.mutable_data()->append(reinterpret_cast<const char*>(at), sizeof at);
  }
  return cloud;
}

class GridDisplayTest : public SceneTest {};

TEST_F(GridDisplayTest, DrawsAMapWithPointsOnIt) {
  Add("Point cloud", "cloud", {"color", "flat", "flat", "#ff4000", "size", "3"});
  Add("Grid", "map");
  Publish("map", Rooms());
  Publish("cloud", Diagonal());
  Update();
  ExpectAsKept("grid_map");
}

TEST_F(GridDisplayTest, DrawsTransparentCostsOverTheMap) {
  Add("Grid", "costs", {"palette", "costmap", "alpha", "0.7"});
  Add("Grid", "map");
  Publish("map", Rooms());
  Publish("costs", Costs());
  Update();
  ExpectAsKept("grid_costs_over_map");
}

TEST_F(GridDisplayTest, DrawsRawValues) {
  Add("Grid", "heights");
  Publish("heights", Heights());
  Update();
  ExpectAsKept("grid_raw");
}

TEST_F(GridDisplayTest, LeavesNothingOfTheOldGridWhenItIsReplaced) {
  Add("Grid", "map");
  Publish("map", Rooms(10));
  Update(0);
  (void)Draw();
  Publish("map", Rooms(24));
  Update(1);
  const Pixels rewritten = Draw();
  Update(10);  // After a rest it is settled again.
  const Pixels settled = Draw();
  scene_.Remove(0);
  Add("Grid", "map");
  Publish("map", Rooms(24));
  Update(11);
  const Pixels fresh = Draw();
  EXPECT_LT(DifferentShare(rewritten, fresh), 0.001);
  EXPECT_LT(DifferentShare(settled, fresh), 0.001);
}

TEST_F(GridDisplayTest, SettlesWithoutAnotherMessage) {
  Display& display = Add("Grid", "map");
  Publish("map", Rooms(10));
  Update(0);
  (void)Draw();
  EXPECT_EQ(display.next_change_s(), std::numeric_limits<double>::infinity());
  Publish("map", Rooms(24));
  Update(1);
  EXPECT_EQ(display.next_change_s(), 3);
  Update(3);
  EXPECT_EQ(display.next_change_s(), std::numeric_limits<double>::infinity());
}

TEST_F(GridDisplayTest, MovesWithItsFrame) {
  Add("Grid", "map");
  tree_.Set("map", "odom", Time{1}, RigidTransform());
  foxglove::Grid grid = Rooms();
  grid.set_frame_id("odom");
  Publish("map", grid);
  Update(0);
  const Pixels before = Draw();
  tree_.Set("map", "odom", Time{2}, RigidTransform({1, 0, 0, 0}, {0, 3, 0}));
  transforms_changed_ = true;
  Update(1);
  EXPECT_GT(DifferentShare(before, Draw()), 0.01);
  tree_.Set("map", "odom", Time{3}, RigidTransform());
  transforms_changed_ = true;
  Update(2);
  EXPECT_LT(DifferentShare(before, Draw()), 0.002);
}

TEST_F(GridDisplayTest, LooksTheSameMillionsOfMetersAway) {
  Add("Grid", "map");
  Publish("map", Rooms());
  Update();
  const Pixels here = Draw();
  const Eigen::Vector3d there(500'000, 5'400'000, 256);
  foxglove::Grid grid = Rooms();
  auto& corner = *grid.mutable_pose()->mutable_position();
  corner.set_x(corner.x() + there.x());
  corner.set_y(corner.y() + there.y());
  corner.set_z(corner.z() + there.z());
  Publish("map", grid);
  Update();
  camera_.Follow(RigidTransform(), RigidTransform({1, 0, 0, 0}, there), false);
  EXPECT_LT(DifferentShare(here, Draw()), 0.005);
}

TEST_F(GridDisplayTest, ReadsTheGridAgainWhenThePaletteChanges) {
  Display& display = Add("Grid", "map");
  Publish("map", Rooms());
  Update();
  const Pixels map = Draw();
  const std::vector<Setting> settings = display.Settings();
  ASSERT_EQ(SetFromText(settings.front(), "costmap"), "");
  display.OnSetting("palette");
  Update();
  EXPECT_GT(DifferentShare(map, Draw()), 0.1);
}

TEST_F(GridDisplayTest, ReportsInvalidGrids) {
  Display& display = Add("Grid", "map");
  EXPECT_THAT(display.Status(), Contains(HasSubstr("Nothing has arrived")));
  foxglove::Grid bad = Rooms();
  bad.clear_cell_size();
  Publish("map", bad);
  Update();
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("no size"));
  tree_.SetStatic("map", "other", RigidTransform());
  foxglove::Grid lost = Rooms();
  lost.set_frame_id("nowhere");
  transforms_changed_ = true;
  Publish("map", lost);
  Update();
  EXPECT_THAT(display.Status().front(), HasSubstr("nowhere"));
  Publish("map", Rooms());
  Update();
  EXPECT_FALSE(display.HasFault());
  Publish("map", Empty(PackedElementField::INT8, 1));
  Update();
  EXPECT_THAT(display.Status().front(), HasSubstr("no cells"));
}

/// A board of many colors, cut into textures of the given size.
class Board : public Display {
 public:
  explicit Board(std::size_t most_pixels) : tiles_(most_pixels) {
    std::vector<Rgba> pixels;
    for (unsigned i = 0; i < 100 * 70; ++i) pixels.push_back(MakeRgba(i % 100 * 2, i / 100 * 3, i * 77 % 256));
    tiles_.Set(pixels, 100, 70);
  }
  [[nodiscard]] Change Update(const UpdateContext& /*context*/) override { return Change::kMoving; }
  void DrawMoving(const DrawContext& context) override {
    tiles_.Draw(context, RigidTransform({1, 0, 0, 0}, {-5, -3.5, 0}), {0.1, 0.1}, 1, false);
  }
  [[nodiscard]] std::size_t points() const override { return tiles_.tiles(); }

 private:
  PictureTiles tiles_;
};

TEST_F(GridDisplayTest, LooksTheSameInOneOrManyTextures) {
  const auto drawn = [&](std::unique_ptr<Display> (*make)(const DisplayInputs&), std::size_t tiles) {
    const DisplayType type{"Board", {}, make};
    scene_.Add(type, {session_, "", [] {}});
    Update();
    EXPECT_EQ(scene_.points(), tiles);
    const Pixels pixels = Draw();
    scene_.Remove(0);
    return pixels;
  };
  camera_.LookFromAbove();
  camera_.Zoom(1.8, 160, 120, kPictureSize);
  const Pixels one =
      drawn([](const DisplayInputs&) -> std::unique_ptr<Display> { return std::make_unique<Board>(4096); }, 1);
  const Pixels many =
      drawn([](const DisplayInputs&) -> std::unique_ptr<Display> { return std::make_unique<Board>(32); }, 12);
  EXPECT_LT(DifferentShare(one, many), 0.02);
}

TEST_F(GridDisplayTest, AppliesSettingsWhilePaused) {
  for (const auto& [name, text] : {std::pair("palette", "costmap"), std::pair("alpha", "0.5")}) {
    Display& display = Add("Grid", "grid");
    Publish("grid", Costs());
    Update();
    const Pixels before = Draw();
    Publish("grid", Rooms());
    SetStandingStill(display, name, text);
    const Pixels standing = Draw();
    scene_.Remove(0);
    Add("Grid", "fresh", {name, text});
    Publish("fresh", Costs());
    Update();
    EXPECT_EQ(DifferentShare(standing, Draw()), 0) << name;
    EXPECT_GT(DifferentShare(standing, before), 0.01) << name;
    scene_.Remove(0);
  }
}

TEST_F(GridDisplayTest, BecomesOpaqueAgainWhilePaused) {
  Display& display = Add("Grid", "grid", {"palette", "raw"});
  Publish("grid", Costs());
  Update();
  const Pixels whole = Draw();
  SetStandingStill(display, "alpha", "0.3");
  EXPECT_GT(DifferentShare(Draw(), whole), 0.01);
  SetStandingStill(display, "alpha", "1");
  EXPECT_EQ(DifferentShare(Draw(), whole), 0);
}

TEST_F(GridDisplayTest, ReturnsTheValueOfACell) {
  Display& display = Add("Grid", "map");
  Publish("map", Rooms());
  Update();
  const auto middle = [](int column, int row) {
    return Eigen::Vector3d((column + 0.5 - 0.5 * kColumns) * kCell, (row + 0.5 - 0.5 * kRows) * kCell, 0);
  };
  EXPECT_EQ(display.ValueAt(middle(0, 0), 0.1), "value = 100");
  EXPECT_EQ(display.ValueAt(middle(5, 5), 0.1), "value = 0");
  EXPECT_EQ(display.ValueAt(middle(kColumns - 1, 5), 0.1), "value = -1");
  EXPECT_EQ(display.ValueAt(middle(kColumns, 5), 0.1), "") << "beside it";
  EXPECT_EQ(display.ValueAt(middle(0, 0) + Eigen::Vector3d::UnitZ(), 0.1), "") << "above it";
  SetStandingStill(display, "palette", "costmap");
  EXPECT_EQ(display.ValueAt(middle(0, 0), 0.1), "value = 100") << "read again with another setting";
}

}  // namespace
}  // namespace hgros::viewer::test
