#include "viewer/data/mesh/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "meshes-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  fs::path folder_;
  std::vector<TriangleCorner> corners_;
};

TEST_F(MeshFile, ReadsAnStlWithUpperOrLowerCaseExtension) {
  const fs::path path = Write("one.STL", "solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendsolid");
  ASSERT_EQ(ReadMesh(path, corners_), "");
  ASSERT_EQ(corners_.size(), 3U);
  EXPECT_EQ(corners_[2].position, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(AlphaOf(corners_[2].color), 0U);
}

TEST_F(MeshFile, RefusesAFolder) {
  fs::create_directory(folder_ / "folder.stl");
  EXPECT_THAT(ReadMesh(folder_ / "folder.stl", corners_), HasSubstr("is not a file that can be read"));
}

constexpr const char* kCollada = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
  <library_effects><effect id="e"><profile_COMMON><technique sid="t"><phong>
    <diffuse><color>1 0.5 0 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="9">0 0 0 1000 0 0 0 0 2000</float_array>
      <technique_common><accessor source="#a" count="3" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"><bind_material><technique_common>
    <instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#w"/></scene>
</COLLADA>)";

TEST_F(MeshFile, ReadsColladaInMetersWithItsAxesAndColors) {
  const std::string fault = ReadMesh(Write("one.dae", kCollada), corners_);
  if (fault.find("ssimp") != std::string::npos) GTEST_SKIP() << fault;
  ASSERT_EQ(fault, "");
  ASSERT_EQ(corners_.size(), 3U);
  EXPECT_TRUE(corners_[1].position.isApprox(Eigen::Vector3d(1, 0, 0), 1e-6));
  EXPECT_TRUE(corners_[2].position.isApprox(Eigen::Vector3d(0, 0, 2), 1e-6));
  EXPECT_EQ(corners_[0].color, MakeRgba(255, 128, 0));
}

TEST_F(MeshFile, ReportsUnreadableFiles) {
  EXPECT_THAT(ReadMesh(folder_ / "none.stl", corners_), HasSubstr("is not a file that can be read"));
  EXPECT_THAT(ReadMesh(Write("one.txt", ""), corners_), HasSubstr("one.txt"));
  EXPECT_THAT(ReadMesh(Write("bad.stl", "solid x\nvertex 0 0 zero\n"), corners_), HasSubstr("bad.stl"));
  EXPECT_TRUE(corners_.empty());
}

}  // namespace
}  // namespace hgros::viewer
