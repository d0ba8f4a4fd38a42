#include <gmock/gmock.h>

#include <filesystem>

#include "support/scratch_folder.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kRobot = R"(<robot name="rover">
  <material name="blue"><color rgba="0.2 0.4 0.9 1"/></material>
  <material name="dark"><color rgba="0.25 0.25 0.28 1"/></material>
  <material name="orange"><color rgba="1 0.55 0.1 1"/></material>
  <link name="base">
    <visual><origin xyz="0 0 0.9"/><geometry><box size="3 1.8 0.8"/></geometry><material name="blue"/></visual>
    <collision><origin xyz="0 0 0.9"/><geometry><cylinder radius="2" length="2"/></geometry></collision>
  </link>
  <link name="left"><visual><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.6" length="0.3"/></geometry>
    <material name="dark"/></visual></link>
  <link name="right"><visual><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.6" length="0.3"/></geometry>
    <material name="dark"/></visual></link>
  <link name="head"><visual><geometry><sphere radius="0.45"/></geometry></visual></link>
  <link name="mast"><visual><geometry><mesh filename="package://rover/meshes/mast.stl" scale="2 2 2"/></geometry>
    <material name="orange"/></visual></link>
  <joint name="l" type="continuous"><parent link="base"/><child link="left"/></joint>
  <joint name="r" type="continuous"><parent link="base"/><child link="right"/></joint>
  <joint name="h" type="fixed"><parent link="base"/><child link="head"/></joint>
  <joint name="m" type="fixed"><parent link="base"/><child link="mast"/></joint>
</robot>)";

/// A pyramid, 0.3 m wide and 0.8 m high.
constexpr const char* kMast = R"(solid mast
facet normal 0 0 0 outer loop vertex -.15 -.15 0 vertex .15 -.15 0 vertex 0 0 .8 endloop endfacet
facet normal 0 0 0 outer loop vertex .15 -.15 0 vertex .15 .15 0 vertex 0 0 .8 endloop endfacet
facet normal 0 0 0 outer loop vertex .15 .15 0 vertex -.15 .15 0 vertex 0 0 .8 endloop endfacet
facet normal 0 0 0 outer loop vertex -.15 .15 0 vertex -.15 -.15 0 vertex 0 0 .8 endloop endfacet
endsolid mast
)";

/// Has a robot's package in a folder.
class RobotDisplayTest : public SceneTest {
 protected:
  void SetUp() override {
    SceneTest::SetUp();
    fs::create_directories(folder_ / "rover/urdf");
    fs::create_directories(folder_ / "rover/meshes");
    folder_.Write("rover/urdf/rover.urdf", kRobot);
    folder_.Write("rover/meshes/mast.stl", kMast);
  }

  void PlaceLinks(const RigidTransform& T_map_base = {}) {
    const auto at = [](double x, double y, double z) { return RigidTransform({1, 0, 0, 0}, {x, y, z}); };
    tree_.Set("map", "base", Time{++stamps_}, T_map_base);
    tree_.SetStatic("base", "left", at(0.7, 1.1, 0.6));
    tree_.SetStatic("base", "right", at(0.7, -1.1, 0.6));
    tree_.SetStatic("base", "head", at(1.1, 0, 1.7));
    tree_.SetStatic("base", "mast", at(-1, 0, 1.3));
    transforms_changed_ = true;
  }
  /// Shows the robot with its links in their places.
  Display& ShowRobot(std::vector<std::string> settings = {}) {
    settings.insert(settings.begin(), {"file", urdf_});
    Display& display = Add("Robot model", "", settings);
    PlaceLinks();
    Update();
    return display;
  }

  const hgros::test::ScratchFolder folder_;
  const std::string urdf_ = folder_ / "rover/urdf/rover.urdf";
  std::int64_t stamps_ = 0;
};

TEST_F(RobotDisplayTest, PlacesLinksAtTheirFrames) {
  Add("Ground");
  Display& display = ShowRobot();
  camera_.Zoom(2.5, 160, 120, kPictureSize);
  ExpectAsKept("robot");
  EXPECT_FALSE(display.HasFault()) << display.Status().front();
  EXPECT_THAT(display.Status(), Contains(HasSubstr("5 shapes, 1 of them meshes")));
}

TEST_F(RobotDisplayTest, DrawsATransparentRobot) {
  Add("Ground");
  ShowRobot({"alpha", "0.4"});
  camera_.Zoom(2.5, 160, 120, kPictureSize);
  ExpectAsKept("robot_see_through");
}

TEST_F(RobotDisplayTest, DoesNotReadTheFileAgainWhenAlphaChanges) {
  Add("Ground");
  Display& display = ShowRobot();
  fs::remove_all(folder_ / "rover");
  Set(display, "alpha", "0.4");
  Update();
  EXPECT_TRUE(scene_.pending());
  EXPECT_FALSE(display.HasFault()) << display.Status().front();
  camera_.Zoom(2.5, 160, 120, kPictureSize);
  ExpectAsKept("robot_see_through");
}

TEST_F(RobotDisplayTest, RedrawsOnlyWhenLinksMove) {
  Display& display = ShowRobot();
  const Pixels before = Draw();
  EXPECT_TRUE(display.Bounds().contains(Eigen::Vector3d(0, 0, 1)));
  PlaceLinks();
  Update();
  EXPECT_FALSE(scene_.pending());
  PlaceLinks(RigidTransform({1, 0, 0, 0}, {0, 4, 0}));
  Update();
  EXPECT_TRUE(scene_.pending());
  EXPECT_GT(DifferentShare(before, Draw()), 0.01);
  EXPECT_FALSE(display.Bounds().contains(Eigen::Vector3d(0, 0, 1)));
}

TEST_F(RobotDisplayTest, DrawsCollisionShapes) {
  Display& display = ShowRobot({"shows", "collision"});
  EXPECT_NEAR(display.Bounds().max().x(), 2, 1e-6);
}

TEST_F(RobotDisplayTest, ReportsLinksWithoutATransform) {
  Display& display = Add("Robot model", "", {"file", urdf_});
  tree_.Set("map", "elsewhere", Time{1}, RigidTransform());
  Update();
  EXPECT_FALSE(display.HasFault()) << "they may still come";
  Update(kLongestWaitS);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("a transform is missing: base, head, left and 2 more"));
  PlaceLinks();
  Update();
  EXPECT_FALSE(display.HasFault());
}

TEST_F(RobotDisplayTest, PlacesUnmovedLinksAsTheDescriptionSays) {
  Display& display = Add("Robot model", "", {"file", urdf_});
  tree_.Set("map", "base", Time{1}, RigidTransform({1, 0, 0, 0}, {7, 0, 0}));
  Update();
  EXPECT_FALSE(display.HasFault());
  EXPECT_THAT(display.Status(),
              Contains("No transform moves l, r: they are shown at zero. Publish the joints: docs/tf.md."));
  EXPECT_NEAR(display.Bounds().max().x(), 8.5, 1e-6);
  PlaceLinks();
  Update();
  EXPECT_THAT(display.Status(), Not(Contains(HasSubstr("stand"))));
}

TEST_F(RobotDisplayTest, ShowsTheRobotWhenNothingIsPublished) {
  Display& display = Add("Robot model", "", {"file", urdf_});
  Update();
  EXPECT_FALSE(display.HasFault());
  EXPECT_THAT(display.Status(), Contains("There are no transforms: base is placed at the fixed frame."));
  EXPECT_TRUE(display.Bounds().contains(Eigen::Vector3d(0, 0, 1)));
}

TEST_F(RobotDisplayTest, ReportsMissingMeshesBeforePlaces) {
  fs::remove(folder_ / "rover/meshes/mast.stl");
  const Display& display = Add("Robot model", "", {"file", urdf_});
  Update();
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("a mesh is missing: mast.stl."));
  EXPECT_THAT(display.Status(), Contains(HasSubstr("5 shapes")));
  EXPECT_THAT(display.Status(), Contains("There are no transforms: base is placed at the fixed frame."));
}

TEST_F(RobotDisplayTest, ReportsAnInvalidFile) {
  Display& display = Add("Robot model");
  Update();
  EXPECT_THAT(display.Status().front(), HasSubstr("Set the setting file to a URDF"));
  for (const fs::path& wrong : {folder_ / "nothing", folder_.path()}) {
    Set(display, "file", wrong);
    Update();
    EXPECT_TRUE(display.HasFault());
    EXPECT_THAT(display.Status().front(), HasSubstr("is not a file that can be read")) << wrong;
  }
}

TEST_F(RobotDisplayTest, LooksTheSameMillionsOfMetersAway) {
  ShowRobot();
  const Pixels here = Draw();
  const RigidTransform there({1, 0, 0, 0}, {500'000, 5'400'000, 256});
  PlaceLinks(there);
  Update();
  camera_.Follow(RigidTransform(), there, false);
  EXPECT_LT(DifferentShare(here, Draw()), 0.01);
}

}  // namespace
}  // namespace hgros::viewer::test
