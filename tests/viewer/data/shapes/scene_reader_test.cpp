#include "viewer/data/shapes/scene_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "viewer/data/cut_text.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer {
namespace {

using foxglove::LinePrimitive;
using foxglove::SceneEntity;
using test::SetColor;
using test::SetXyz;
using ::testing::HasSubstr;

Eigen::Vector3d At(const SolidShape& shape, double x, double y, double z) {
  return shape.pose * Eigen::Vector4d(x, y, z, 1);
}

SceneShapes Read(const SceneEntity& entity) {
  SceneShapes shapes;
  EXPECT_EQ(ReadScene(entity, shapes), "");
  return shapes;
}

TEST(SceneReader, ReadsACubeAsAStretchedUnitCube) {
  SceneEntity entity;
  auto& cube = *entity.add_cubes();
  cube.mutable_pose()->mutable_position()->set_x(10);
  cube.mutable_pose()->mutable_orientation()->set_z(std::sqrt(0.5));
  cube.mutable_pose()->mutable_orientation()->set_w(std::sqrt(0.5));
  SetXyz(*cube.mutable_size(), 2, 4, 6);
  SetColor(*cube.mutable_color(), 1, 0.5, 0);
  const SceneShapes shapes = Read(entity);
  ASSERT_EQ(shapes.cubes.size(), 1U);
  EXPECT_TRUE(At(shapes.cubes[0], 0.5, 0, 0).isApprox(Eigen::Vector3d(10, 1, 0))) << "x points to y";
  EXPECT_TRUE(At(shapes.cubes[0], 0, 0.5, 0.5).isApprox(Eigen::Vector3d(8, 0, 3)));
  EXPECT_EQ(shapes.cubes[0].color, MakeRgba(255, 128, 0));
}

TEST(SceneReader, ReadsAnArrowAsACylinderAndAConeAlongX) {
  SceneEntity entity;
  auto& arrow = *entity.add_arrows();
  arrow.set_shaft_length(3);
  arrow.set_shaft_diameter(0.2);
  arrow.set_head_length(1);
  arrow.set_head_diameter(0.6);
  const SceneShapes shapes = Read(entity);
  ASSERT_EQ(shapes.cylinders.size(), 2U);
  const SolidShape &shaft = shapes.cylinders[0], &head = shapes.cylinders[1];
  EXPECT_LT(At(shaft, 0, 0, -0.5).norm(), 1e-12);
  EXPECT_TRUE(At(shaft, 0, 0, 0.5).isApprox(Eigen::Vector3d(3, 0, 0)));
  EXPECT_TRUE(At(head, 0, 0, 0.5).isApprox(Eigen::Vector3d(4, 0, 0))) << "its tip";
  EXPECT_EQ(head.bottom_scale, 1);
  EXPECT_EQ(head.top_scale, 0);
  EXPECT_NEAR((At(head, 0, 0.5, 0) - At(head, 0, -0.5, 0)).norm(), 0.6, 1e-12);
}

TEST(SceneReader, CutsLinesIntoPieces) {
  const auto pieces = [](LinePrimitive::Type type, int points) {
    SceneEntity entity;
    auto& line = *entity.add_lines();
    line.set_type(type);
    line.set_thickness(2);
    line.set_scale_invariant(true);
    for (int i = 0; i < points; ++i) SetXyz(*line.add_points(), i, 0, 0);
    return Read(entity).lines;
  };
  EXPECT_EQ(pieces(LinePrimitive::LINE_STRIP, 4).size(), 3U);
  EXPECT_EQ(pieces(LinePrimitive::LINE_LIST, 5).size(), 2U);
  const auto loop = pieces(LinePrimitive::LINE_LOOP, 4);
  ASSERT_EQ(loop.size(), 4U);
  EXPECT_EQ(loop[3].to, Eigen::Vector3d(0, 0, 0));
  EXPECT_TRUE(loop[0].pixels);
  EXPECT_EQ(loop[0].thickness, 2);
  EXPECT_TRUE(pieces(LinePrimitive::LINE_LOOP, 1).empty());
  EXPECT_TRUE(pieces(LinePrimitive::LINE_STRIP, 0).empty());
}

TEST(SceneReader, ReadsPointsWithColorsAndIndices) {
  SceneEntity entity;
  auto& line = *entity.add_lines();
  for (int i = 0; i < 3; ++i) {
    SetXyz(*line.add_points(), i, 0, 0);
    SetColor(*line.add_colors(), i / 2.0, 0, 0);
  }
  for (const unsigned index : {2U, 0U}) line.add_indices(index);
  const SceneShapes shapes = Read(entity);
  ASSERT_EQ(shapes.lines.size(), 1U);
  EXPECT_EQ(shapes.lines[0].from.x(), 2);
  EXPECT_EQ(shapes.lines[0].from_color, MakeRgba(255, 0, 0));
  EXPECT_EQ(shapes.lines[0].to_color, MakeRgba(0, 0, 0));
}

TEST(SceneReader, ReadsTrianglesWithIndices) {
  SceneEntity entity;
  auto& list = *entity.add_triangles();
  for (const double x : {0.0, 1.0, 2.0, 3.0}) SetXyz(*list.add_points(), x, x * x, 0);
  for (const unsigned index : {0U, 1U, 2U, 1U, 2U, 3U}) list.add_indices(index);
  const SceneShapes shapes = Read(entity);
  ASSERT_EQ(shapes.triangles.size(), 6U);
  EXPECT_EQ(shapes.triangles[5].position.x(), 3);
  EXPECT_EQ(shapes.size(), 2U);
}

TEST(SceneReader, ReadsConesTextsAndModels) {
  SceneEntity entity;
  auto& cone = *entity.add_cylinders();
  cone.set_bottom_scale(1);
  cone.set_top_scale(0);
  auto& text = *entity.add_texts();
  text.set_text("hello");
  text.set_billboard(true);
  text.set_font_size(0.5);
  auto& model = *entity.add_models();
  model.set_url("package://robot/base.stl");
  const SceneShapes shapes = Read(entity);
  EXPECT_EQ(shapes.cylinders.at(0).top_scale, 0);
  EXPECT_EQ(shapes.texts.at(0).text, "hello");
  EXPECT_TRUE(shapes.texts.at(0).billboard);
  EXPECT_EQ(shapes.models.at(0).url, "package://robot/base.stl");
}

TEST(SceneReader, ReportsAnInvalidPrimitiveAndDrawsTheRest) {
  SceneEntity entity;
  entity.add_cubes()->mutable_size()->set_x(std::numeric_limits<double>::quiet_NaN());
  (void)entity.add_cubes();
  SceneShapes shapes;
  EXPECT_EQ(ReadScene(entity, shapes), "Cube 0 has a size that is not a number.");
  EXPECT_EQ(shapes.cubes.size(), 1U);

  const auto fault = [](const auto& fill) {
    SceneEntity one;
    fill(one);
    SceneShapes ignored;
    return ReadScene(one, ignored);
  };
  EXPECT_THAT(fault([](SceneEntity& one) { one.add_triangles()->add_indices(7); }), HasSubstr("uses point 7 of 0"));
  EXPECT_THAT(fault([](SceneEntity& one) { SetColor(*one.add_lines()->add_colors(), 1, 1, 1); }),
              HasSubstr("1 colors for 0 points"));
  EXPECT_THAT(fault([](SceneEntity& one) { SetXyz(*one.add_triangles()->add_points(), 1, 1, 1); }),
              HasSubstr("not a multiple of 3"));
  EXPECT_THAT(fault([](SceneEntity& one) { one.add_arrows()->set_head_length(-1); }),
              HasSubstr("negative or invalid lengths"));
  EXPECT_THAT(fault([](SceneEntity& one) { (void)one.add_models(); }), HasSubstr("names no file"));
  EXPECT_THAT(fault([](SceneEntity& one) {
                one.add_spheres()->mutable_pose()->mutable_position()->set_x(std::numeric_limits<double>::infinity());
              }),
              HasSubstr("Sphere 0 has a pose"));
}

TEST(SceneReader, CutsLongTexts) {
  SceneEntity entity;
  entity.add_texts()->set_text(std::string(24'000, 'x'));
  EXPECT_EQ(Read(entity).texts.at(0).text.size(), kMaxShownBytes);
}

TEST(SceneReader, ClampsColors) {
  foxglove::Color color;
  SetColor(color, -1, 2, std::numeric_limits<double>::quiet_NaN(), 0.5);
  EXPECT_EQ(ReadColor(color), MakeRgba(0, 255, 0, 128));
}

}  // namespace
}  // namespace hgros::viewer
