#include "viewer/data/shapes/shape_reader.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "viewer/data/shapes/scene_store.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer {
namespace {

// An L, which is not convex; its area is 3.
void FillL(PolygonShape* polygon) {
  constexpr std::array<std::array<int, 2>, 6> kCorners{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
  for (const auto& [x, y] : kCorners) test::SetXy(*polygon->add_corners(), x, y);
}

double AreaOf(const SceneShapes& shapes) {
  double area = 0;
  for (std::size_t i = 0; i + 2 < shapes.triangles.size(); i += 3) {
    const auto& a = shapes.triangles[i].position;
    area += (shapes.triangles[i + 1].position - a).cross(shapes.triangles[i + 2].position - a).norm() / 2;
  }
  return area;
}

SceneShapes Read(const Shape& shape) {
  SceneShapes shapes;
  EXPECT_EQ(ReadShape(shape, shapes), "");
  return shapes;
}

TEST(ShapeReader, ReadsFlatShapesAsTriangles) {
  Shape l;
  FillL(l.mutable_polygon());
  l.mutable_color()->set_g(1);
  l.mutable_color()->set_a(0.5);
  const SceneShapes shapes = Read(l);
  EXPECT_NEAR(AreaOf(shapes), 3, 1e-12);
  EXPECT_EQ(shapes.triangles[0].color, MakeRgba(0, 255, 0, 128));
  Shape oval;
  oval.mutable_oval()->set_a(2);
  oval.mutable_oval()->set_b(1);
  EXPECT_NEAR(AreaOf(Read(oval)), 2 * M_PI, 0.05);
}

TEST(ShapeReader, ReadsAnExtrudedPolygonWithWalls) {
  Shape shape;
  FillL(shape.mutable_extrusion()->mutable_polygon());
  shape.mutable_extrusion()->set_height(0.5);
  shape.mutable_pose()->mutable_position()->set_z(10);
  const SceneShapes shapes = Read(shape);
  EXPECT_NEAR(AreaOf(shapes), 2 * 3 + 8 * 0.5, 1e-12);
  for (const auto& corner : shapes.triangles) {
    EXPECT_GE(corner.position.z(), 10);
    EXPECT_LE(corner.position.z(), 10.5);
  }
}

TEST(ShapeReader, ReadsRoundSolidsAsStretchedUnitShapes) {
  Shape cone;
  cone.mutable_cone()->mutable_base()->set_a(1);
  cone.mutable_cone()->mutable_base()->set_b(2);
  cone.mutable_cone()->set_height(3);
  const SceneShapes cones = Read(cone);
  ASSERT_EQ(cones.cylinders.size(), 1U);
  EXPECT_EQ(cones.cylinders[0].top_scale, 0);
  EXPECT_TRUE((cones.cylinders[0].pose * Eigen::Vector4d(0, 0, 0.5, 1)).isApprox(Eigen::Vector3d(0, 0, 3)));
  EXPECT_TRUE((cones.cylinders[0].pose * Eigen::Vector4d(0.5, 0, -0.5, 1)).isApprox(Eigen::Vector3d(1, 0, 0)));
  Shape extrusion;
  extrusion.mutable_extrusion()->mutable_oval()->set_a(1);
  extrusion.mutable_extrusion()->set_height(1);
  EXPECT_EQ(Read(extrusion).cylinders.at(0).top_scale, 1);
  Shape ellipsoid;
  ellipsoid.mutable_ellipsoid()->mutable_half_axes()->set_x(4);
  EXPECT_EQ(Read(ellipsoid).spheres.at(0).pose(0, 0), 8);
}

TEST(ShapeReader, ReadsPointsAndLinesWithSizesInPixels) {
  Shape point;
  point.mutable_point()->mutable_position()->set_x(1);
  point.mutable_point()->set_width(7);
  EXPECT_EQ(Read(point).lines.at(0).thickness, 7);
  EXPECT_TRUE(Read(point).lines.at(0).pixels);
  Shape line;
  for (int i = 0; i < 4; ++i) line.mutable_line()->add_points()->set_x(i);
  EXPECT_EQ(Read(line).lines.size(), 3U);
}

TEST(ShapeReader, ReportsInvalidShapes) {
  const auto fault = [](const auto& fill) {
    Shape shape;
    fill(shape);
    SceneShapes shapes;
    std::string said = ReadShape(shape, shapes);
    EXPECT_EQ(shapes.size(), 0U);
    return said;
  };
  EXPECT_EQ(fault([](Shape&) {}), "The shape is of an unknown kind.");
  EXPECT_EQ(fault([](Shape& shape) { (void)shape.mutable_polygon(); }), "The shape has no area.");
  EXPECT_EQ(fault([](Shape& shape) { (void)shape.mutable_extrusion(); }), "The shape has no area.");
  EXPECT_EQ(fault([](Shape& shape) { shape.mutable_cone()->mutable_base()->set_a(-1); }),
            "The shape has half axes that are not lengths.");
  EXPECT_EQ(fault([](Shape& shape) { shape.mutable_extrusion()->set_height(NAN); }),
            "The shape has a height that is not a number.");
  EXPECT_EQ(fault([](Shape& shape) { shape.mutable_pose()->mutable_position()->set_x(NAN); }),
            "The shape has a pose that is not a number.");
}

TEST(ShapeReader, ReplacesAndRemovesShapesByName) {
  SceneStore store;
  Shapes update;
  for (const char* name : {"a", "b", "c"}) {
    auto& shape = *update.add_shapes();
    shape.set_name(name);
    (void)shape.mutable_point();
  }
  EXPECT_EQ(store.Apply(update), "");
  EXPECT_EQ(store.entities().size(), 3U);
  Shapes less;
  less.add_removed("a");
  EXPECT_EQ(store.Apply(less), "");
  EXPECT_EQ(store.entities().size(), 2U);
  update.set_remove_all(true);
  update.mutable_shapes()->DeleteSubrange(1, 2);
  update.mutable_shapes(0)->clear_point();
  EXPECT_EQ(store.Apply(update), "Shape \"a\": The shape is of an unknown kind.");
  EXPECT_EQ(store.entities().size(), 1U);
}

}  // namespace
}  // namespace hgros::viewer
