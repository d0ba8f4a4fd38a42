#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/scratch_folder.hpp"
#include "viewer/data/mesh/mesh_file.hpp"
#include "viewer/data/mesh/model_meshes.hpp"

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MeshFile : public ::testing::Test {
 protected:
  const hgros::test::ScratchFolder folder_;
  std::vector<TriangleCorner> corners_;
};

TEST_F(MeshFile, ReadsAnStlWithUpperOrLowerCaseExtension) {
  const fs::path path = folder_.Write("one.STL", "solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendsolid");
  ASSERT_EQ(ReadMesh(path, corners_), "");
  ASSERT_EQ(corners_.size(), 3U);
  EXPECT_EQ(corners_[2].position, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(AlphaOf(corners_[2].color), 0U);
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
  const std::string fault = ReadMesh(folder_.Write("one.dae", kCollada), corners_);
  if (fault.find("ssimp") != std::string::npos) GTEST_SKIP() << fault;
  ASSERT_EQ(fault, "");
  ASSERT_EQ(corners_.size(), 3U);
  EXPECT_TRUE(corners_[1].position.isApprox(Eigen::Vector3d(1, 0, 0), 1e-6));
  EXPECT_TRUE(corners_[2].position.isApprox(Eigen::Vector3d(0, 0, 2), 1e-6));
  EXPECT_EQ(corners_[0].color, MakeRgba(255, 128, 0));
}

TEST_F(MeshFile, ReportsUnreadableFilesAndFolders) {
  fs::create_directory(folder_ / "folder.stl");
  EXPECT_THAT(ReadMesh(folder_ / "folder.stl", corners_), HasSubstr("is not a file that can be read"));
  EXPECT_THAT(ReadMesh(folder_ / "none.stl", corners_), HasSubstr("is not a file that can be read"));
  EXPECT_THAT(ReadMesh(folder_.Write("one.txt", ""), corners_), HasSubstr("one.txt"));
  EXPECT_THAT(ReadMesh(folder_.Write("bad.stl", "solid x\nvertex 0 0 zero\n"), corners_), HasSubstr("bad.stl"));
  EXPECT_TRUE(corners_.empty());
}

constexpr const char* kStl = "solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendsolid";

/// Twice as large, one meter up.
SceneModel Model(const std::string& data = kStl, const std::string& media_type = "model/stl") {
  SceneModel model;
  model.data = data;
  model.media_type = media_type;
  model.pose.setZero();
  model.pose.leftCols<3>().diagonal().setConstant(2);
  model.pose(2, 3) = 1;
  return model;
}

TEST(ModelMeshes, AreReadFromTheMessageItself) {
  SceneShapes shapes;
  shapes.models = {Model(), Model()};
  shapes.models.back().override_color = true;
  shapes.models.back().color = MakeRgba(1, 2, 3, 4);
  ModelMeshes meshes;
  ASSERT_EQ(meshes.AddTo(shapes), "");
  ASSERT_EQ(shapes.triangles.size(), 6U);
  EXPECT_EQ(shapes.triangles[2].position, Eigen::Vector3d(0, 4, 1));
  EXPECT_EQ(AlphaOf(shapes.triangles[2].color), 255U);
  EXPECT_EQ(shapes.triangles[5].color, MakeRgba(1, 2, 3, 4));
}

TEST(ModelMeshes, ReportTheirDistance) {
  SceneShapes shapes;
  shapes.models = {Model()};
  ModelMeshes meshes;
  EXPECT_TRUE(std::isinf(meshes.DistanceTo(shapes.models, {0, 0, 0}, 9))) << "not read yet";
  ASSERT_EQ(meshes.AddTo(shapes), "");
  EXPECT_NEAR(meshes.DistanceTo(shapes.models, {0.5, 0.5, 4}, 9), 3, 1e-9);
  EXPECT_NEAR(meshes.DistanceTo(shapes.models, {5, 0, 1}, 9), 3, 1e-9);
  EXPECT_TRUE(std::isinf(meshes.DistanceTo({}, {0, 0, 0}, 9)));
  EXPECT_TRUE(std::isinf(meshes.DistanceTo(shapes.models, {5, 0, 1}, 2.9))) << "too far";
  EXPECT_TRUE(std::isinf(meshes.DistanceTo(shapes.models, {1.9, 3.9, 1}, 0.1))) << "in the box, beside the triangle";
  shapes.models[0].override_color = true;
  EXPECT_TRUE(std::isinf(meshes.DistanceTo(shapes.models, {0.5, 0.5, 1}, 9))) << "it is invisible";
}

TEST(ModelMeshes, AreReadOnceFromNamedFiles) {
  const hgros::test::ScratchFolder folder;
  SceneModel model = Model("", "");
  model.url = "file://" + folder.Write("part.stl", kStl).string();
  ModelMeshes meshes;
  for (int turn = 0; turn < 2; ++turn) {
    SceneShapes shapes;
    shapes.models.push_back(model);
    EXPECT_EQ(meshes.AddTo(shapes), "");
    EXPECT_EQ(shapes.triangles.size(), 3U);
    std::filesystem::remove_all(folder.path());  // It is kept in memory.
  }
  SceneShapes none;
  EXPECT_EQ(meshes.AddTo(none), "");
  SceneShapes later;
  later.models.push_back(model);
  EXPECT_THAT(meshes.AddTo(later), HasSubstr("part.stl"));
}

TEST(ModelMeshes, AreReadFromUrlsWithCodedCharacters) {
  const hgros::test::ScratchFolder folder;
  (void)folder.Write("a part%.stl", kStl);
  SceneShapes shapes;
  for (const char* name : {"a%20part%.stl", "%61%20part%25.stl"}) {
    shapes.models.push_back(Model("", ""));
    shapes.models.back().url = "file://" + folder.path().string() + "/" + name;
  }
  EXPECT_EQ(ModelMeshes().AddTo(shapes), "");
  EXPECT_EQ(shapes.triangles.size(), 6U);
}

TEST(ModelMeshes, ReportABrokenModelAndDrawTheOthers) {
  SceneShapes shapes;
  shapes.models = {Model("glTF", "model/gltf-binary"), Model()};
  ModelMeshes meshes;
  EXPECT_THAT(meshes.AddTo(shapes), HasSubstr("gltf"));
  EXPECT_EQ(shapes.triangles.size(), 3U);
}

}  // namespace
}  // namespace hgros::viewer
