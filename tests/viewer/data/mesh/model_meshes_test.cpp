#include "viewer/data/mesh/model_meshes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kStl = "solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendsolid";

/// Twice as large, one meter up.
SceneModel Model() {
  SceneModel model;
  model.pose.setZero();
  model.pose.leftCols<3>().diagonal().setConstant(2);
  model.pose(2, 3) = 1;
  return model;
}

TEST(ModelMeshes, AreReadFromTheMessageItself) {
  SceneShapes shapes;
  SceneModel& model = shapes.models.emplace_back(Model());
  model.media_type = "model/stl";
  model.data = kStl;
  shapes.models.push_back(model);
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
  SceneModel& model = shapes.models.emplace_back(Model());
  model.media_type = "model/stl";
  model.data = kStl;
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
  std::string name = (fs::temp_directory_path() / "models-XXXXXX").string();
  const fs::path folder = mkdtemp(name.data());
  const fs::path file = folder / "part.stl";
  std::ofstream(file) << kStl;
  SceneModel model = Model();
  model.url = "file://" + file.string();
  ModelMeshes meshes;
  for (int turn = 0; turn < 2; ++turn) {
    SceneShapes shapes;
    shapes.models.push_back(model);
    EXPECT_EQ(meshes.AddTo(shapes), "");
    EXPECT_EQ(shapes.triangles.size(), 3U);
    fs::remove_all(folder);  // It is kept in memory.
  }
  SceneShapes none;
  EXPECT_EQ(meshes.AddTo(none), "");
  SceneShapes later;
  later.models.push_back(model);
  EXPECT_THAT(meshes.AddTo(later), HasSubstr("part.stl"));
}

TEST(ModelMeshes, ReportABrokenModelAndDrawTheOthers) {
  SceneShapes shapes;
  SceneModel& bad = shapes.models.emplace_back(Model());
  bad.media_type = "model/gltf-binary";
  bad.data = "glTF";
  SceneModel& good = shapes.models.emplace_back(Model());
  good.media_type = "model/stl";
  good.data = kStl;
  ModelMeshes meshes;
  EXPECT_THAT(meshes.AddTo(shapes), HasSubstr("gltf"));
  EXPECT_EQ(shapes.triangles.size(), 3U);
}

}  // namespace
}  // namespace hgros::viewer
