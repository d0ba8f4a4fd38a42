#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "hgros/Shapes.pb.h"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using foxglove::SceneEntity;
using foxglove::SceneUpdate;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kForEver = std::numeric_limits<double>::infinity();

void SetColor(foxglove::Color& color, double r, double g, double b, double a = 1) {
  color.set_r(r);
  color.set_g(g);
  color.set_b(b);
  color.set_a(a);
}

void Place(foxglove::Pose& pose, double x, double y, double z) { SetXyz(*pose.mutable_position(), x, y, z); }

SceneEntity& AddEntity(SceneUpdate& update, const std::string& id) {
  SceneEntity& entity = *update.add_entities();
  entity.set_id(id);
  entity.set_frame_id("map");
  return entity;
}

void AddCube(SceneEntity& entity, double x, double y, double edge = 1, double alpha = 1) {
  auto& cube = *entity.add_cubes();
  Place(*cube.mutable_pose(), x, y, 0.5 * edge);
  SetXyz(*cube.mutable_size(), edge, edge, edge);
  SetColor(*cube.mutable_color(), 0.9, 0.5, 0.1, alpha);
}

/// One solid of every kind.
SceneUpdate EverySolid() {
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "solids");
  AddCube(entity, -3, -2, 1.6);
  auto& sphere = *entity.add_spheres();
  Place(*sphere.mutable_pose(), 0, -2, 0.8);
  SetXyz(*sphere.mutable_size(), 1.6, 1.6, 1.2);
  SetColor(*sphere.mutable_color(), 0.2, 0.7, 0.3);
  auto& cylinder = *entity.add_cylinders();
  Place(*cylinder.mutable_pose(), 3, -2, 0.8);
  SetXyz(*cylinder.mutable_size(), 1.4, 1.4, 1.6);
  cylinder.set_bottom_scale(1);
  cylinder.set_top_scale(1);
  SetColor(*cylinder.mutable_color(), 0.2, 0.5, 0.9);
  auto& cone = *entity.add_cylinders();
  Place(*cone.mutable_pose(), -3, 2, 0.8);
  SetXyz(*cone.mutable_size(), 1.6, 1.6, 1.6);
  cone.set_bottom_scale(1);
  SetColor(*cone.mutable_color(), 0.8, 0.2, 0.6);
  auto& arrow = *entity.add_arrows();
  Place(*arrow.mutable_pose(), -1, 2, 0.5);
  arrow.mutable_pose()->mutable_orientation()->set_y(-std::sin(0.2));
  arrow.mutable_pose()->mutable_orientation()->set_w(std::cos(0.2));
  arrow.set_shaft_length(1.6);
  arrow.set_shaft_diameter(0.25);
  arrow.set_head_length(0.7);
  arrow.set_head_diameter(0.6);
  SetColor(*arrow.mutable_color(), 0.95, 0.85, 0.2);
  auto& triangles = *entity.add_triangles();
  for (const auto& [x, y, z] : {std::array{2.0, 1.2, 0.0},
                                {4.2, 1.2, 0.0},
                                {3.1, 3.0, 0.0},
                                {2.0, 1.2, 0.0},
                                {3.1, 3.0, 0.0},
                                {3.1, 1.8, 1.8},
                                {4.2, 1.2, 0.0},
                                {3.1, 1.8, 1.8},
                                {3.1, 3.0, 0.0}}) {
    SetXyz(*triangles.add_points(), x, y, z);
    SetColor(*triangles.add_colors(), 0.2 + z / 3, 0.6, 0.7);
  }
  return update;
}

/// A strip, a loop and a list, in meters, in pixels, and with a color gradient.
SceneUpdate EveryLine() {
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "lines");
  for (const auto type :
       {foxglove::LinePrimitive::LINE_STRIP, foxglove::LinePrimitive::LINE_LOOP, foxglove::LinePrimitive::LINE_LIST}) {
    auto& line = *entity.add_lines();
    line.set_type(type);
    line.set_thickness(type == foxglove::LinePrimitive::LINE_LOOP ? 0.25 : 4);
    line.set_scale_invariant(type != foxglove::LinePrimitive::LINE_LOOP);
    Place(*line.mutable_pose(), 0, 3.0 - 3 * static_cast<int>(type), 0.2);
    for (int i = 0; i < 8; ++i) {
      SetXyz(*line.add_points(), i - 3.5, i % 2 == 0 ? -0.9 : 0.9, 0);
      SetColor(*line.add_colors(), i / 7.0, 0.8, 1 - i / 7.0);
    }
  }
  return update;
}

class EntityDisplayTest : public SceneTest {
 protected:
  std::string FirstStatus(const Display& display) { return display.Status().front(); }
};

TEST_F(EntityDisplayTest, DrawsEverySolid) {
  Add("Ground");
  Add("Scene", "scene");
  Publish("scene", EverySolid());
  Update();
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("scene_solids");
}

TEST_F(EntityDisplayTest, DrawsEveryKindOfLine) {
  Add("Ground");
  Add("Scene", "scene");
  Publish("scene", EveryLine());
  Update();
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("scene_lines");
}

TEST_F(EntityDisplayTest, DrawsTransparentEntitiesAfterOpaqueOnes) {
  Add("Scene", "scene");
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "see-through");
  AddCube(entity, -1.5, -1.5, 2, 0.4);
  AddCube(entity, 1.5, 1.5, 2);
  auto& sphere = *entity.add_spheres();
  Place(*sphere.mutable_pose(), -1.5, -1.5, 1);
  SetXyz(*sphere.mutable_size(), 1, 1, 1);
  SetColor(*sphere.mutable_color(), 0.2, 0.7, 0.3);
  auto& glass = *entity.add_cylinders();
  Place(*glass.mutable_pose(), 0, 0, 1);
  SetXyz(*glass.mutable_size(), 2, 2, 3);
  glass.set_bottom_scale(1);
  glass.set_top_scale(0.6);
  SetColor(*glass.mutable_color(), 0.4, 0.6, 1, 0.35);
  Publish("scene", update);
  Update();
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("scene_see_through");
}

TEST_F(EntityDisplayTest, DrawsTransparentChannelsFromBackToFront) {
  for (const double edge : {1.0, 3.0}) {  // One inside the other.
    const std::string channel = edge < 2 ? "inner" : "outer";
    Add("Scene", channel);
    SceneUpdate update;
    AddCube(AddEntity(update, channel), 0, 0, edge, 0.5);
    SetColor(*update.mutable_entities(0)->mutable_cubes(0)->mutable_color(), edge < 2 ? 0.9 : 0.1, 0.2, 0.5, 0.5);
    Publish(channel, update);
  }
  Update();
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  const Pixels before = Draw();
  scene_.MoveUp(1);
  scene_.Redraw();
  EXPECT_TRUE(before == Draw());
}

TEST_F(EntityDisplayTest, DrawsThePapersShapes) {
  Add("Ground");
  Add("Shapes", "shapes");
  Shapes shapes;
  shapes.set_frame_id("map");
  int count = 0;
  const auto add = [&](double x, double y) -> Shape& {
    Shape& shape = *shapes.add_shapes();
    shape.set_name("shape " + std::to_string(count));
    Place(*shape.mutable_pose(), x, y, 0.05);
    SetColor(*shape.mutable_color(), 0.3 + 0.1 * (count % 7), 0.9 - 0.1 * (count % 7), 0.5);
    ++count;
    return shape;
  };
  add(-3, 2).mutable_point()->set_width(12);
  auto& line = *add(-1, 2).mutable_line();
  for (int i = 0; i < 6; ++i) SetXyz(*line.add_points(), 0.3 * i, i % 2 == 0 ? 0 : 0.8, 0);
  auto& polygon = *add(2, 2).mutable_polygon();
  for (int i = 0; i < 10; ++i) {
    auto& corner = *polygon.add_corners();
    const double angle = std::numbers::pi * i / 5;
    corner.set_x((i % 2 == 0 ? 1.0 : 0.4) * std::cos(angle));
    corner.set_y((i % 2 == 0 ? 1.0 : 0.4) * std::sin(angle));
  }
  auto& oval = *add(-3, -1).mutable_oval();
  oval.set_a(1);
  oval.set_b(0.5);
  SetXyz(*add(-0.5, -1).mutable_ellipsoid()->mutable_half_axes(), 0.9, 0.5, 0.5);
  auto& cone = *add(2, -1).mutable_cone();
  cone.mutable_base()->set_a(0.8);
  cone.mutable_base()->set_b(0.8);
  cone.set_height(1.5);
  auto& post = *add(-2, -3.5).mutable_extrusion();
  post.mutable_oval()->set_a(0.5);
  post.mutable_oval()->set_b(0.8);
  post.set_height(1);
  auto& wedge = *add(1, -3.5).mutable_extrusion();
  for (const auto& [x, y] : {std::array{-0.8, -0.8}, {0.8, -0.8}, {0.8, 0.8}, {0.0, 0.0}}) {
    auto& corner = *wedge.mutable_polygon()->add_corners();
    corner.set_x(x);
    corner.set_y(y);
  }
  wedge.set_height(1);
  Publish("shapes", shapes);
  Update();
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("shapes_of_the_paper");
}

TEST_F(EntityDisplayTest, RemovesExpiredEntitiesWithoutAMessage) {
  Display& display = Add("Scene", "scene");
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "short");
  AddCube(entity, 0, 0, 3);
  entity.mutable_timestamp()->set_seconds(session_.clock()->Now().nanoseconds / 1'000'000'000 - 100);
  entity.mutable_lifetime()->set_seconds(200);
  Publish("scene", update);
  Update(1);
  EXPECT_GT(DifferentShare(empty, Draw()), 0.01);
  EXPECT_GT(display.next_change_s(), 1 + 98);
  EXPECT_LT(display.next_change_s(), 1 + 102);
  entity.mutable_lifetime()->set_seconds(50);
  Publish("scene", update);
  Update(2);
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
  Update(10);
  EXPECT_EQ(display.next_change_s(), kForEver);
}

TEST_F(EntityDisplayTest, LeavesNothingAfterDeletingTwoThousandOneByOne) {
  Display& display = Add("Scene", "scene");
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate all;
  for (int i = 0; i < 2000; ++i) {
    const int row = i / 50;
    AddCube(AddEntity(all, std::to_string(i)), i % 50 * 0.2 - 5, row * 0.2 - 4, 0.15);
  }
  Publish("scene", all);
  Update(1);
  EXPECT_THAT(display.Status(), Contains(HasSubstr("2000 entities")));
  EXPECT_GT(DifferentShare(empty, Draw()), 0.1);
  for (int part = 0; part < 20; ++part) {
    SceneUpdate deletions;
    for (int i = part; i < 2000; i += 20) deletions.add_deletions()->set_id(std::to_string(i));
    Publish("scene", deletions);
    Update(1 + 0.1 * part);
    (void)Draw();
  }
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
  EXPECT_THAT(FirstStatus(display), HasSubstr("No entity"));
}

TEST_F(EntityDisplayTest, MovesOnlyEntitiesLockedToAFrame) {
  Display& display = Add("Scene", "scene");
  tree_.Set("map", "base", Time{1'000}, RigidTransform());
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "cube");
  AddCube(entity, 0, 0, 2);
  entity.set_frame_id("base");
  for (const bool locked : {false, true}) {
    SCOPED_TRACE(locked);
    entity.set_frame_locked(locked);
    entity.mutable_timestamp()->set_nanos(locked ? 0 : 1'000);
    Publish("scene", update);
    Update(locked ? 10 : 0);
    const Pixels before = Draw();
    tree_.Set("map", "base", Time{locked ? 3'000 : 2'000}, RigidTransform({1, 0, 0, 0}, {0, locked ? 6.0 : 3.0, 0}));
    transforms_changed_ = true;
    Update(locked ? 11 : 1);
    EXPECT_EQ(DifferentShare(before, Draw()) > 0.01, locked);
    EXPECT_FALSE(display.HasFault());
  }
}

TEST_F(EntityDisplayTest, KeepsEntitiesWhereTheirFrameWasLongAgo) {
  Add("Scene", "scene");
  tree_.Set("map", "base", Time{1'000}, RigidTransform());
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "old");
  AddCube(entity, 0, 0, 2);
  entity.set_frame_id("base");
  entity.mutable_timestamp()->set_nanos(1'000);
  Publish("scene", update);
  Update(0);
  const Pixels before = Draw();
  for (int s = 1; s <= 30; ++s)
    tree_.Set("map", "base", Time{s * 1'000'000'000L}, RigidTransform({1, 0, 0, 0}, {0, 5, 0}));
  SceneUpdate other;
  AddCube(AddEntity(other, "new"), 100, 100, 0.01);
  Publish("scene", other);
  transforms_changed_ = true;
  Update(1);
  EXPECT_LT(DifferentShare(before, Draw()), 0.002);
}

TEST_F(EntityDisplayTest, ReportsAMissingTransformAndShowsEntitiesWithIt) {
  Display& display = Add("Scene", "scene");
  tree_.SetStatic("map", "other", RigidTransform());
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "cube");
  AddCube(entity, 0, 0, 2);
  entity.set_frame_id("arm");
  Publish("scene", update);
  Update(0);
  EXPECT_FALSE(display.HasFault()) << "it may still come";
  EXPECT_THAT(display.WaitsFor(), HasSubstr("arm"));
  EXPECT_EQ(display.next_change_s(), kLongestWaitS);
  Update(kLongestWaitS);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(FirstStatus(display), HasSubstr("arm"));
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
  tree_.SetStatic("map", "arm", RigidTransform());
  transforms_changed_ = true;
  Update(3);
  EXPECT_FALSE(display.HasFault());
  EXPECT_GT(DifferentShare(empty, Draw()), 0.01);
}

TEST_F(EntityDisplayTest, LooksTheSameMillionsOfMetersAway) {
  Add("Scene", "scene");
  Publish("scene", EverySolid());
  Update(0);
  const Pixels here = Draw();
  const Eigen::Vector3d there(500'000, 5'400'000, 256);
  tree_.SetStatic("map", "utm", RigidTransform({1, 0, 0, 0}, there));
  transforms_changed_ = true;
  SceneUpdate update = EverySolid();
  update.mutable_entities(0)->set_frame_id("utm");
  Publish("scene", update);
  Update(1);
  camera_.Follow(RigidTransform(), RigidTransform({1, 0, 0, 0}, there), false);
  EXPECT_LT(DifferentShare(here, Draw()), 0.01);
}

TEST_F(EntityDisplayTest, EntitiesTooFarAwayDoNotHideOthers) {
  Display& display = Add("Scene", "scene");
  Publish("scene", EverySolid());
  Update(0);
  const Pixels before = Draw();
  SceneUpdate far;
  AddCube(AddEntity(far, "far"), 9e307, 0);
  AddCube(AddEntity(far, "as far"), 9e307, 9e307);
  AddCube(AddEntity(far, "in a far frame"), 0, 0);
  far.mutable_entities(2)->set_frame_id("nowhere");
  tree_.SetStatic("map", "nowhere", RigidTransform({1, 0, 0, 0}, {9e11, 0, 0}));
  transforms_changed_ = true;
  Publish("scene", far);
  Update(1);
  Update(1 + kLongestWaitS);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(FirstStatus(display), HasSubstr("Entity \"far\": 1 of its shapes"));
  EXPECT_THAT(display.Status(), Contains(HasSubstr("The frame nowhere is farther away")));
  EXPECT_EQ(DifferentShare(before, Draw()), 0);
  Publish("scene", EverySolid());
  Update(4);
  EXPECT_EQ(DifferentShare(before, Draw()), 0);
}

TEST_F(EntityDisplayTest, OneMalformedEntityLeavesTheBoundsOfTheOthers) {
  Display& display = Add("Scene", "scene");
  Publish("scene", EverySolid());
  Update();
  const Eigen::AlignedBox3d before = display.Bounds();
  for (const double size : {1e9, -1e9, 3e8, std::nan(""), HUGE_VAL}) {
    SceneUpdate bad;
    AddCube(AddEntity(bad, "bad"), 0, 0, size);
    Publish("scene", bad);
    Update();
    EXPECT_TRUE(display.Bounds().isApprox(before)) << size << ": " << display.Bounds().sizes().transpose();
    EXPECT_TRUE(scene_.Bounds().isApprox(before)) << size;
  }
  SceneUpdate bad;
  auto& model = *AddEntity(bad, "bad").add_models();
  SetXyz(*model.mutable_scale(), 1, 1, 1);
  model.set_media_type("model/stl");
  model.set_data("solid x\nvertex 0 0 0\nvertex 1e30 0 0\nvertex 0 1 0\nendsolid");
  Publish("scene", bad);
  Update();
  EXPECT_TRUE(display.Bounds().isApprox(before)) << "a corner of a mesh";
}

TEST_F(EntityDisplayTest, OneMalformedChannelLeavesTheBoundsOfTheOthers) {
  Add("Scene", "scene");
  Add("Scene", "bad");
  Add("Pose", "far");
  Publish("scene", EverySolid());
  Update();
  const Eigen::AlignedBox3d before = scene_.Bounds();
  SceneUpdate bad;
  AddCube(AddEntity(bad, "bad"), 0, 0, 1e9);
  Publish("bad", bad);
  foxglove::PoseInFrame far;
  far.mutable_pose()->mutable_position()->set_x(1e30);
  Publish("far", far);
  Update();
  EXPECT_TRUE(scene_.Bounds().isApprox(before)) << scene_.Bounds().sizes().transpose();
}

TEST_F(EntityDisplayTest, ReturnsTextsAsLabelsWithPlaceAndColor) {
  Display& display = Add("Scene", "scene");
  SceneUpdate update;
  auto& text = *AddEntity(update, "text").add_texts();
  Place(*text.mutable_pose(), 1, 2, 3);
  text.set_text("kitchen");
  text.set_font_size(0.5);
  SetColor(*text.mutable_color(), 1, 0, 0);
  Publish("scene", update);
  Update();
  const std::vector<Label> labels = display.Labels();
  ASSERT_EQ(labels.size(), 1U);
  EXPECT_EQ(labels[0].text, "kitchen");
  EXPECT_EQ(labels[0].at, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(labels[0].color, MakeRgba(255, 0, 0));
  EXPECT_EQ(labels[0].height, 0.5F);
  EXPECT_TRUE(labels[0].in_meters);
}

TEST_F(EntityDisplayTest, DrawsAModelInsideTheMessage) {
  Display& display = Add("Scene", "scene");
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate update;
  auto& model = *AddEntity(update, "model").add_models();
  SetXyz(*model.mutable_scale(), 3, 3, 3);
  model.set_media_type("model/stl");
  model.set_data("solid x\nvertex -1 -1 0\nvertex 1 -1 0\nvertex 0 1 1\nendsolid");
  Publish("scene", update);
  Update(1);
  EXPECT_GT(DifferentShare(empty, Draw()), 0.02);
  EXPECT_NEAR(display.Bounds().max().z(), 3, 1e-6);
  EXPECT_FALSE(display.HasFault());
}

TEST_F(EntityDisplayTest, ReportsAMalformedMessage) {
  Display& display = Add("Scene", "scene");
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "bad");
  AddCube(entity, std::nan(""), 0);
  Publish("scene", update);
  Update();
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(FirstStatus(display), HasSubstr("\"bad\""));
  (void)Draw();
}

TEST_F(EntityDisplayTest, AppliesSettingsWhilePaused) {
  Display& display = Add("Scene", "scene");
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "cube");
  entity.set_frame_id("base");
  entity.set_frame_locked(true);
  AddCube(entity, 0, 0, 3);
  (void)tree_.Set("map", "base", Time{1'000'000'000}, RigidTransform({1, 0, 0, 0}, {0, 0, 0}));
  Publish("scene", update);
  Update();
  (void)Draw();
  (void)tree_.Set("map", "base", Time{2'000'000'000}, RigidTransform({1, 0, 0, 0}, {4, 0, 0}));
  SceneUpdate deleted;
  deleted.add_deletions()->set_type(foxglove::SceneEntityDeletion::ALL);
  Publish("scene", deleted);
  SetStandingStill(display, "alpha", "0.4");
  const Pixels faded = Draw();
  EXPECT_DOUBLE_EQ(display.Bounds().center().x(), 0) << "its frame has not moved in this picture";
  SetStandingStill(display, "alpha", "1");
  EXPECT_GT(DifferentShare(faded, Draw()), 0.01);
}

}  // namespace
}  // namespace hgros::viewer::test
