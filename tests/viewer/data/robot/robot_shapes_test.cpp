#include "viewer/data/robot/robot_shapes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/scratch_folder.hpp"
#include "viewer/data/mesh/mesh_place.hpp"
#include "viewer/data/mesh/stl_mesh.hpp"

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kRobot = R"(<robot name="r">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <visual><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><geometry><box size="1 2 3"/></geometry><material name="red"/></visual>
    <visual><geometry><mesh filename="package://r/base.stl" scale="2 2 2"/></geometry></visual>
    <collision><geometry><sphere radius="0.5"/></geometry></collision>
  </link>
  <link name="arm"><visual><geometry><cylinder radius="0.1" length="2"/></geometry></visual></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>
</robot>)";

TEST(RobotShapes, AreReadForEachLink) {
  std::vector<RobotShape> shapes;
  ASSERT_EQ(ReadRobot(kRobot, "left/", RobotSide::kVisual, shapes), "");
  ASSERT_EQ(shapes.size(), 3U);
  const RobotShape &arm = shapes[0], &box = shapes[1], &mesh = shapes[2];
  EXPECT_EQ(arm.link, "left/arm");
  EXPECT_EQ(arm.kind, RobotShape::Kind::kCylinder);
  EXPECT_TRUE(arm.size.isApprox(Eigen::Vector3d(0.2, 0.2, 2)));
  EXPECT_FALSE(arm.colored);
  EXPECT_EQ(box.color, MakeRgba(255, 0, 0));
  EXPECT_TRUE((box.T_link_shape * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3)));
  EXPECT_EQ(mesh.mesh, "package://r/base.stl");
  EXPECT_EQ(mesh.size, Eigen::Vector3d(2, 2, 2));
}

TEST(RobotShapes, ReadVisualsOrCollisions) {
  std::vector<RobotShape> shapes;
  ASSERT_EQ(ReadRobot(kRobot, "", RobotSide::kCollision, shapes), "");
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_EQ(shapes[0].kind, RobotShape::Kind::kSphere);
  EXPECT_EQ(shapes[0].size, Eigen::Vector3d(1, 1, 1));
}

TEST(RobotShapes, ReportAnInvalidUrdf) {
  std::vector<RobotShape> shapes(7);
  EXPECT_EQ(ReadRobot("<robot", "", RobotSide::kVisual, shapes), "The robot's description is not a URDF.");
  EXPECT_EQ(shapes.size(), 7U);
}

TEST(RobotShapes, AreReadForARealRobot) {
  const char* const data = std::getenv("HGROS_DATA");
  const fs::path path = fs::path(data == nullptr ? "" : data) / "robots" / "fetch.urdf";
  if (!fs::exists(path)) GTEST_SKIP() << "HGROS_DATA names no folder with robots/fetch.urdf";
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  std::vector<RobotShape> shapes;
  ASSERT_EQ(ReadRobot(text.str(), "", RobotSide::kVisual, shapes), "");
  EXPECT_GE(shapes.size(), 15U);
}

class MeshPlace : public testing::Test {
 protected:
  MeshPlace() {
    fs::create_directories(scratch_ / "r/meshes");
    scratch_.Write("r/meshes/a.stl", "x");
  }
  const hgros::test::ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
};

TEST_F(MeshPlace, FindsPackagesInAFolderOrAsTheFolder) {
  std::string fault;
  const fs::path file = folder_ / "r" / "meshes" / "a.stl";
  EXPECT_EQ(FindMesh("package://r/meshes/a.stl", {"/nowhere", folder_}, fault), file);
  EXPECT_EQ(FindMesh("package://r/meshes/a.stl", {folder_ / "r"}, fault), file);
  EXPECT_EQ(FindMesh("r/meshes/a.stl", {folder_}, fault), file);
  EXPECT_EQ(FindMesh("file://" + file.string(), {}, fault), file);
  EXPECT_EQ(FindMesh(file.string(), {}, fault), file);
}

TEST_F(MeshPlace, RefusesNamesThatLeadOutOfTheFolder) {
  std::string fault;
  EXPECT_EQ(FindMesh("package://r/../../etc/passwd", {folder_}, fault), "");
  EXPECT_THAT(fault, HasSubstr("is not a valid name for a mesh"));
  EXPECT_EQ(FindMesh("../" + folder_.filename().string() + "/r/meshes/a.stl", {folder_}, fault), "");
  EXPECT_EQ(FindMesh("http://example.org/a.stl", {folder_}, fault), "");
  EXPECT_THAT(fault, HasSubstr("was not found in " + folder_.string()));
  EXPECT_EQ(FindMesh("package://r/b.stl", {}, fault), "");
  EXPECT_THAT(fault, HasSubstr("no folder for meshes is given"));
}

TEST_F(MeshPlace, ReadsFoldersFromTheEnvironment) {
  setenv("HGROS_MESH_PATH", "/one::/two", 1);
  unsetenv("ROS_PACKAGE_PATH");
  EXPECT_EQ(MeshFolders({"/zero"}), (std::vector<fs::path>{"/zero", "/one", "/two"}));
  unsetenv("HGROS_MESH_PATH");
}

std::string BinaryStl(std::uint32_t said, std::uint32_t triangles, const std::string& head = "solid binary") {
  std::string file = head;
  file.resize(80);
  file.append(reinterpret_cast<const char*>(&said), 4);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(i)};
    file.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    file.append(2, '\0');
  }
  return file;
}

TEST(StlMesh, ReadsTextAndBinaryFiles) {
  std::vector<Eigen::Vector3f> corners;
  ASSERT_EQ(ReadStl(AsBytes(BinaryStl(2, 2)), corners), "") << "although it begins like a text file";
  ASSERT_EQ(corners.size(), 6U);
  EXPECT_EQ(corners[5], Eigen::Vector3f(0, 1, 1));
  const std::string text =
      "solid a\nfacet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1e0 0 0\r\n vertex 0 -1.5 0\n "
      "endloop\nendfacet\n"
      "endsolid a\n";
  ASSERT_EQ(ReadStl(AsBytes(text), corners), "");
  ASSERT_EQ(corners.size(), 3U);
  EXPECT_EQ(corners[2], Eigen::Vector3f(0, -1.5F, 0));
}

TEST(StlMesh, ReportsDamagedFiles) {
  std::vector<Eigen::Vector3f> corners(5);
  const auto fault = [&](const std::string& file) { return ReadStl(AsBytes(file), corners); };
  EXPECT_THAT(fault(""), HasSubstr("ends before its first"));
  EXPECT_THAT(fault(BinaryStl(3, 2, "x")), HasSubstr("announces 3 triangles"));
  EXPECT_THAT(fault(BinaryStl(4'000'000'000, 2, "x")), HasSubstr("announces 4000000000"));
  EXPECT_THAT(fault("solid a vertex 0 0 zero"), HasSubstr("\"zero\" instead of a number"));
  EXPECT_THAT(fault("solid a vertex 0 0"), HasSubstr("instead of a number"));
  EXPECT_THAT(fault("solid a vertex 0 0 0"), HasSubstr("in the middle of a triangle"));
  EXPECT_THAT(fault("solid a vertex nan 0 0 vertex 0 0 0 vertex 1 1 1"), HasSubstr("not numbers"));
  EXPECT_THAT(fault("solid"), HasSubstr("no triangles"));
  EXPECT_EQ(corners.size(), 5U);
}

}  // namespace
}  // namespace hgros::viewer
