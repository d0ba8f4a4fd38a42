#include <memory>
#include <string>

#include "foxglove/Grid.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "foxglove/VoxelGrid.pb.h"
#include "hgros/Shapes.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

/// One point with an intensity.
foxglove::PointCloud PointAt(float x, float y, float z, float intensity, const std::string& frame = "map") {
  foxglove::PointCloud cloud;
  cloud.set_frame_id(frame);
  SetFloatFields(cloud);
  const float values[] = {x, y, z, intensity};
  cloud.mutable_data()->assign(reinterpret_cast<const char*>(values), sizeof values);  // NOLINT: bytes are bytes
  return cloud;
}

class PickingTest : public SceneTest {
 protected:
  void SetUp() override {
    SceneTest::SetUp();
    camera_.LookFromAbove();
  }
  /// Picks at a point. Sets `found_`.
  const Scene::Entry* EntryAt(const Eigen::Vector3d& at) {
    (void)Draw();
    const auto pixel = camera_.PixelOf(at, kPictureSize);
    int x = static_cast<int>(pixel->x());
    int y = static_cast<int>(pixel->y());
    float depth = scene_.NearestDepth(camera_.Matrices(kPictureSize), 1, x, y, 3);
    if (depth >= 1) return nullptr;
    const Scene::Entry* const entry = scene_.EntryAt(camera_.Matrices(kPictureSize), 1, x, y, depth);
    found_ = camera_.PointAt(x + 0.5, y + 0.5, static_cast<double>(depth), kPictureSize);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return entry;
  }
  /// The name of the picked display; empty if there is none.
  std::string NameAt(const Eigen::Vector3d& at) {
    const Scene::Entry* const entry = EntryAt(at);
    return entry == nullptr ? "" : entry->name;
  }
  /// What the picked display says about the picked point; empty if there is none.
  std::string ToldAt(const Eigen::Vector3d& at) {
    const Scene::Entry* const entry = EntryAt(at);
    return entry == nullptr ? "" : entry->display->ValueAt(found_, 0.1);
  }

  Eigen::Vector3d found_;
};

TEST_F(PickingTest, ReturnsPositionDisplayFrameAndValue) {
  for (const char* keep : {"latest", "all"}) {
    const std::string channel = std::string("cloud_") + keep;
    Add("Ground");
    const double side = keep == std::string("latest") ? 1 : -1;
    ASSERT_EQ(tree_.SetStatic("map", "lidar", RigidTransform({1, 0, 0, 0}, {0, 0, 1})).text(), "");
    Show("Point cloud", channel, PointAt(static_cast<float>(3 * side), 2, 0.5F, 42, "lidar"),
         {"keep", keep, "color", "value", "size", "5"});
    const Eigen::Vector3d at(3 * side, 2, 1.5);
    const Scene::Entry* const entry = EntryAt(at);
    ASSERT_NE(entry, nullptr) << keep;
    EXPECT_EQ(entry->name, channel);
    EXPECT_LT((found_ - at).norm(), 0.15);
    EXPECT_EQ(entry->display->data_frame(), "lidar");
    const std::string value = entry->display->ValueAt(found_, 0.5);
    EXPECT_TRUE(value.starts_with("intensity = 42")) << value;
    EXPECT_EQ(entry->display->ValueAt(found_ + Eigen::Vector3d(3, 0, 0), 0.5), "");
  }
}

TEST_F(PickingTest, ReturnsTheFrontDisplay) {
  Add("Point cloud", "low", {"size", "9"});
  Add("Point cloud", "high", {"size", "9"});
  Publish("low", PointAt(0, 0, 0, 1));
  Send("high", PointAt(0, 0, 2, 1));
  EXPECT_EQ(NameAt({0, 0, 2}), "high");
  EXPECT_NEAR(found_.z(), 2, 0.05);
}

/// Two cells of 4 m, side by side, 1 m above the ground. The left one has no cost.
foxglove::Grid TwoCells() {
  foxglove::Grid grid;
  grid.set_frame_id("map");
  SetXyz(*grid.mutable_pose()->mutable_position(), -4, -2, 1);
  SetCells(grid, 2, 1, 4);
  AddField(grid, "cost", foxglove::PackedElementField::INT8);
  grid.set_data(std::string({0, 50}));
  return grid;
}

TEST_F(PickingTest, ReturnsTransparentThingsButNotInvisibleOnes) {
  Show("Point cloud", "below", PointAt(-2, 0, 0, 1), {"size", "9"});
  Display& costs = Show("Grid", "costs", TwoCells(), {"palette", "costmap"});
  EXPECT_EQ(NameAt({-2, 0, 1}), "below");
  for (const char* alpha : {"1", "0.3"}) {
    SetStandingStill(costs, "alpha", alpha);
    EXPECT_EQ(NameAt({2, 0, 1}), "costs");
    EXPECT_NEAR(found_.z(), 1, 0.05);
    EXPECT_EQ(ToldAt({2, 0, 1}), "cost = 50");
  }
  SetStandingStill(costs, "alpha", "0");
  EXPECT_EQ(EntryAt({2, 0, 1}), nullptr);
}

TEST_F(PickingTest, ReturnsTheHeightOfAGridExactly) {
  foxglove::Grid grid = TwoCells();
  SetXyz(*grid.mutable_pose()->mutable_position(), -40, -40, 0);
  SetXy(*grid.mutable_cell_size(), 40, 80);
  Display& costs = Show("Grid", "costs", grid, {"palette", "map"});
  for (const char* alpha : {"1", "0.5"}) {
    SetStandingStill(costs, "alpha", alpha);
    camera_.Reset();
    for (const double pitch : {0.0, 0.2, 0.35, -0.5}) {  // The last ones look almost along the grid, and from above.
      camera_.Orbit(0.3, pitch);
      EXPECT_EQ(NameAt({2, 1, 0}), "costs");
      EXPECT_NEAR(found_.z(), 0, 1e-3) << "alpha " << alpha << ", pitch " << pitch;
    }
  }
}

TEST_F(PickingTest, ReturnsWhatLiesInThePlaneOfAGrid) {
  foxglove::Grid grid = TwoCells();
  grid.mutable_pose()->mutable_position()->set_z(0);
  Show("Grid", "costs", grid, {"palette", "map"});
  Show("Point cloud", "cloud", PointAt(2, 0, 0, 1), {"size", "9"});
  EXPECT_EQ(NameAt({2, 0, 0}), "cloud") << "the grid lets it cover itself";
}

/// Fills the picture at half the depth, if it is visible, and counts how often it is drawn.
class Curtain : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& /*context*/) override { return Change::kNothing; }
  void DrawMoving(const DrawContext& /*context*/) override {
    ++drawn;
    if (!closed) return;
    glClearDepth(0.5);
    glClear(GL_DEPTH_BUFFER_BIT);
    glClearDepth(1);
  }
  bool closed = false;
  int drawn = 0;
};

TEST_F(PickingTest, DrawsOnlyWhatItNeeds) {
  const DisplayType type{
      "Curtain", {}, [](const DisplayInputs&) -> std::unique_ptr<Display> { return std::make_unique<Curtain>(); }};
  auto& curtain = static_cast<Curtain&>(*scene_.Add(type, {session_, "", [] {}}).display);
  Show("Grid", "costs", TwoCells(), {"palette", "map"});
  EXPECT_EQ(NameAt({2, 0, 1}), "costs");
  const ViewMatrices view = camera_.Matrices(kPictureSize);
  const auto pixel = camera_.PixelOf({2, 0, 1}, kPictureSize);
  int x = static_cast<int>(pixel->x());
  int y = static_cast<int>(pixel->y());
  float depth = scene_.NearestDepth(view, 1, x, y, 3);
  const float moved_back = depth;
  curtain.drawn = 0;
  scene_.CorrectDepth(view, 1, x, y, depth);
  EXPECT_EQ(curtain.drawn, 0) << "it has its true depth anyway";
  EXPECT_LT(depth, moved_back);
  EXPECT_NEAR(camera_.PointAt(x + 0.5, y + 0.5, static_cast<double>(depth), kPictureSize).z(), 1, 1e-3);
  curtain.closed = true;
  scene_.Redraw();
  (void)Draw();
  depth = scene_.NearestDepth(view, 1, x, y, 3);
  curtain.drawn = 0;
  const Scene::Entry* const entry = scene_.EntryAt(view, 1, x, y, depth);
  ASSERT_NE(entry, nullptr);
  EXPECT_EQ(entry->display.get(), &curtain);
  EXPECT_EQ(curtain.drawn, 1);
  scene_.Remove(0);
}

TEST_F(PickingTest, ReturnsWhatIsFarFromAllElse) {
  foxglove::SceneUpdate update;
  for (int i = 0; i < 7; ++i) AddCube(AddEntity(update, "thing " + std::to_string(i)), {1.0 * i, 0, 0}, 1);
  AddCube(AddEntity(update, "far thing"), {3e6, 0, 0}, 1000);
  Show("Scene", "things", update);
  const Eigen::Vector3d far(3e6, 0, 500);
  camera_.Focus(Eigen::AlignedBox3d(far - Eigen::Vector3d::Constant(500), far + Eigen::Vector3d::Constant(500)),
                kPictureSize);
  EXPECT_EQ(NameAt(far), "things");
  EXPECT_LT((found_ - far).norm(), 50);
}

TEST_F(PickingTest, ReturnsTheNearestOfSeveralTransparentDisplays) {
  foxglove::SceneUpdate update;
  AddCube(AddEntity(update, "glass"), {2, 0, 2}, 1, 0.2);
  Show("Scene", "things", update);
  Show("Grid", "costs", TwoCells(), {"palette", "costmap", "alpha", "0.5"});
  const Pixels before = Draw();
  EXPECT_EQ(NameAt({2, 0, 2.5}), "things");
  EXPECT_NEAR(found_.z(), 2.5, 0.05);
  EXPECT_EQ(ToldAt({2, 0, 2.5}), "entity \"glass\"");
  EXPECT_EQ(NameAt({3.5, 1.5, 1}), "costs");
  EXPECT_EQ(DifferentShare(Draw(), before), 0) << "picking does not change the picture";
}

TEST_F(PickingTest, ReturnsTheEntityAndItsMetadata) {
  foxglove::SceneUpdate update;
  for (const double x : {-2.0, 2.0}) {
    foxglove::SceneEntity& entity = AddEntity(update, x < 0 ? "left" : "right");
    AddCube(entity, {x, 0, 0}, 1);
    for (int i = 0; i < 20; ++i) {
      auto* const note = entity.add_metadata();
      note->set_key("key" + std::to_string(i));
      note->set_value(std::string(1000, 'v'));
    }
  }
  const Display& display = Show("Scene", "things", update);
  const std::string told = ToldAt({2, 0, 0.5});
  EXPECT_TRUE(told.starts_with("entity \"right\"\nkey0 = vvv")) << told;
  EXPECT_TRUE(told.ends_with("and 8 more")) << told;
  EXPECT_LT(told.size(), 2000U);
  EXPECT_EQ(display.ValueAt({0, 0, 0}, 0.1), "");
}

TEST_F(PickingTest, ReturnsTransparentThingsOfEveryKind) {
  foxglove::SceneUpdate update;
  for (const double alpha : {0.3, 0.0}) {  // An invisible object is above it.
    const std::string name = alpha > 0 ? "seen " : "unseen ";
    const double z = alpha > 0 ? 1 : 2;
    const auto point = [&](auto* at, double x, double y) { SetXyz(*at, x, y, z); };
    auto* const triangle = AddEntity(update, name + "triangle").add_triangles();
    triangle->mutable_color()->set_a(alpha);
    point(triangle->add_points(), -5, -2);
    point(triangle->add_points(), -1, -2);
    point(triangle->add_points(), -3, 2);
    auto* const line = AddEntity(update, name + "line").add_lines();
    line->set_thickness(0.5);
    line->mutable_color()->set_a(alpha);
    point(line->add_points(), 2, -2);
    point(line->add_points(), 2, 2);
    SetSolid(*AddEntity(update, name + "ball").add_spheres(), {0, 3, z}, {1, 1, 1}, {0, 0, 0, alpha});
  }
  foxglove::VoxelGrid voxels;
  voxels.set_frame_id("map");
  voxels.mutable_pose()->mutable_position()->set_x(4);
  SetVoxels(voxels, 1, 1, 1, 1);
  AddField(voxels, "full", foxglove::PackedElementField::UINT8);
  voxels.set_data(std::string(1, 1));
  Show("Scene", "things", update);
  Show("Voxels", "voxels", voxels, {"alpha", "0.5"});
  EXPECT_EQ(ToldAt({-3, 0, 1}), "entity \"seen triangle\"");
  EXPECT_EQ(ToldAt({2, 0, 1}), "entity \"seen line\"");
  EXPECT_EQ(ToldAt({0, 3, 1.5}), "entity \"seen ball\"");
  EXPECT_TRUE(ToldAt({4.5, 0.5, 1}).starts_with("full = 1")) << ToldAt({4.5, 0.5, 1});
}

TEST_F(PickingTest, ReturnsTheEntityOfAModel) {
  foxglove::SceneUpdate update;
  for (const double x : {-3.0, 3.0}) {
    auto* const model = AddEntity(update, x < 0 ? "left" : "right").add_models();
    model->mutable_pose()->mutable_position()->set_x(x);
    SetXyz(*model->mutable_scale(), 2, 2, 2);
    model->set_media_type("model/stl");
    model->set_data("solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendsolid");
  }
  Show("Scene", "things", update);
  EXPECT_EQ(ToldAt({3.5, 0.5, 0}), "entity \"right\"");
}

TEST_F(PickingTest, ReturnsTheNameOfAShape) {
  hgros::Shapes update;
  update.set_frame_id("map");
  auto* const shape = update.add_shapes();
  shape->set_name("disc");
  shape->mutable_oval()->set_a(2);
  shape->mutable_oval()->set_b(2);
  shape->mutable_color()->set_a(1);
  const Display& display = Show("Shapes", "shapes", update);
  EXPECT_EQ(display.ValueAt({1, 1, 0}, 0.1), "shape \"disc\"");
}

TEST_F(PickingTest, DoesNotChangeThePicture) {
  Add("Ground");
  Add("Point cloud", "cloud", {"keep", "all", "size", "5"});
  foxglove::PosesInFrame way;
  for (int i = 0; i < 10; ++i) way.add_poses()->mutable_position()->set_x(i);
  Add("Trajectory", "way");
  Publish("way", way);
  Send("cloud", PointAt(1, 1, 0, 1, "lidar"));
  const Pixels before = Draw();
  // Something new has arrived that was not drawn yet.
  Send("cloud", PointAt(-4, 2, 0, 1, "lidar"));
  float depth = 0.5F;
  (void)scene_.EntryAt(camera_.Matrices(kPictureSize), 1, 160, 120, depth);
  const Pixels after = Draw();
  scene_.Redraw();
  EXPECT_LT(DifferentShare(after, Draw()), 1e-9) << "the new message is drawn";
  EXPECT_GT(DifferentShare(after, before), 0);
}

}  // namespace
}  // namespace hgros::viewer::test
