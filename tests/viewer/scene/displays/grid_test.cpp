#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "foxglove/Grid.pb.h"
#include "viewer/e2e/message_parts.hpp"
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
  SetXyz(*grid.mutable_pose()->mutable_position(), -0.5 * kColumns * kCell, -0.5 * kRows * kCell, 0);
  SetCells(grid, kColumns, bytes, kCell);
  AddField(grid, "value", type);
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
  for (const char* name : {"x", "y", "z"}) AddPointField(cloud, name, PackedElementField::FLOAT32, 4);
  for (int i = 0; i < 200; ++i) {
    const float at[3] = {0.05F * static_cast<float>(i) - 5, 0.04F * static_cast<float>(i) - 4, 0};
    cloud.mutable_data()->append(reinterpret_cast<const char*>(at), sizeof at);
  }
  return cloud;
}

class GridDisplayTest : public SceneTest {};

TEST_F(GridDisplayTest, DrawsAMapWithPointsOnIt) {
  Add("Point cloud", "cloud", {"color", "flat", "flat", "#ff4000", "size", "3"});
  Publish("cloud", Diagonal());
  Show("Grid", "map", Rooms());
  ExpectAsKept("grid_map");
}

TEST_F(GridDisplayTest, DrawsTransparentCostsOverTheMap) {
  Add("Grid", "costs", {"palette", "costmap", "alpha", "0.7"});
  Publish("costs", Costs());
  Show("Grid", "map", Rooms());
  ExpectAsKept("grid_costs_over_map");
}

TEST_F(GridDisplayTest, DrawsRawValues) {
  Show("Grid", "heights", Heights());
  ExpectAsKept("grid_raw");
}

TEST_F(GridDisplayTest, LeavesNothingOfTheOldGridWhenItIsReplaced) {
  ExpectNothingLeftOf(Rooms(10), Rooms(24), 0.001, "Grid");
}

TEST_F(GridDisplayTest, SettlesWithoutAnotherMessage) {
  Display& display = Show("Grid", "map", Rooms(10));
  (void)Draw();
  EXPECT_EQ(display.next_change_s(), std::numeric_limits<double>::infinity());
  Send("map", Rooms(24), 1);
  EXPECT_EQ(display.next_change_s(), 3);
  Update(3);
  EXPECT_EQ(display.next_change_s(), std::numeric_limits<double>::infinity());
}

TEST_F(GridDisplayTest, MovesWithItsFrame) { ExpectItMovesWithItsFrame(Rooms(), 0.01, "Grid"); }

TEST_F(GridDisplayTest, LooksTheSameMillionsOfMetersAway) {
  Show("Grid", "map", Rooms());
  const Pixels here = Draw();
  const Eigen::Vector3d there(500'000, 5'400'000, 256);
  foxglove::Grid grid = Rooms();
  auto& corner = *grid.mutable_pose()->mutable_position();
  SetXyz(corner, corner.x() + there.x(), corner.y() + there.y(), corner.z() + there.z());
  Send("map", grid);
  camera_.Follow(RigidTransform(), RigidTransform({1, 0, 0, 0}, there), false);
  EXPECT_LT(DifferentShare(here, Draw()), 0.005);
}

TEST_F(GridDisplayTest, ReadsTheGridAgainWhenThePaletteChanges) {
  Display& display = Show("Grid", "map", Rooms());
  const Pixels map = Draw();
  Set(display, "palette", "costmap");
  Update();
  EXPECT_GT(DifferentShare(map, Draw()), 0.1);
}

TEST_F(GridDisplayTest, ReportsInvalidGrids) {
  Display& display = Add("Grid", "map");
  EXPECT_THAT(display.Status(), Contains(HasSubstr("Nothing has arrived")));
  foxglove::Grid bad = Rooms();
  bad.clear_cell_size();
  Send("map", bad);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("no size"));
  SetStatic("map", "other");
  foxglove::Grid lost = Rooms();
  lost.set_frame_id("nowhere");
  Send("map", lost);
  EXPECT_THAT(display.Status().front(), HasSubstr("nowhere"));
  Send("map", Rooms());
  EXPECT_FALSE(display.HasFault());
  Send("map", Empty(PackedElementField::INT8, 1));
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
    ExpectEffectWhilePaused(Costs(), Rooms(), "Grid", name, text);
  }
}

TEST_F(GridDisplayTest, BecomesOpaqueAgainWhilePaused) {
  Display& display = Show("Grid", "grid", Costs(), {"palette", "raw"});
  const Pixels whole = Draw();
  SetStandingStill(display, "alpha", "0.3");
  EXPECT_GT(DifferentShare(Draw(), whole), 0.01);
  SetStandingStill(display, "alpha", "1");
  EXPECT_EQ(DifferentShare(Draw(), whole), 0);
}

TEST_F(GridDisplayTest, ReturnsTheValueOfACell) {
  Display& display = Show("Grid", "map", Rooms());
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
