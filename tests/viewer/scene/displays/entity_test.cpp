#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "foxglove/PoseInFrame.pb.h"
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

void Place(foxglove::Pose& pose, double x, double y, double z) { SetXyz(*pose.mutable_position(), x, y, z); }

/// It stands on the ground.
void AddCubeAt(SceneEntity& entity, double x, double y, double edge = 1, double alpha = 1) {
  AddCube(entity, {x, y, 0.5 * edge}, edge, alpha);
}

/// A message of one cube at the origin.
SceneUpdate Cube(const std::string& id, double edge, double alpha = 1) {
  SceneUpdate update;
  AddCubeAt(AddEntity(update, id), 0, 0, edge, alpha);
  return update;
}

/// A message of one triangle.
SceneUpdate Model(const std::string& id, double scale, const std::string& corners) {
  SceneUpdate update;
  auto& model = *AddEntity(update, id).add_models();
  SetXyz(*model.mutable_scale(), scale, scale, scale);
  model.set_media_type("model/stl");
  model.set_data("solid x\n" + corners + "\nendsolid");
  return update;
}

/// One solid of every kind.
SceneUpdate EverySolid() {
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "solids");
  AddCubeAt(entity, -3, -2, 1.6);
  SetSolid(*entity.add_spheres(), {0, -2, 0.8}, {1.6, 1.6, 1.2}, {0.2, 0.7, 0.3, 1});
  auto& cylinder = *entity.add_cylinders();
  SetSolid(cylinder, {3, -2, 0.8}, {1.4, 1.4, 1.6}, {0.2, 0.5, 0.9, 1});
  cylinder.set_bottom_scale(1);
  cylinder.set_top_scale(1);
  auto& cone = *entity.add_cylinders();
  SetSolid(cone, {-3, 2, 0.8}, {1.6, 1.6, 1.6}, {0.8, 0.2, 0.6, 1});
  cone.set_bottom_scale(1);
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
  constexpr std::array<std::array<double, 3>, 4> kCorners{
      {{2.0, 1.2, 0}, {4.2, 1.2, 0}, {3.1, 3.0, 0}, {3.1, 1.8, 1.8}}};
  for (const std::size_t corner : {0U, 1U, 2U, 0U, 2U, 3U, 1U, 3U, 2U}) {
    const auto& [x, y, z] = kCorners[corner];
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

class EntityDisplayTest : public SceneTest {};

TEST_F(EntityDisplayTest, DrawsEverySolidAndEveryKindOfLine) {
  Add("Ground");
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  for (const auto& [name, update] : {std::pair("scene_solids", EverySolid()), std::pair("scene_lines", EveryLine())}) {
    Show("Scene", name, update);
    ExpectAsKept(name);
    scene_.Remove(1);
  }
}

TEST_F(EntityDisplayTest, DrawsTransparentEntitiesAfterOpaqueOnes) {
  SceneUpdate update;
  SceneEntity& entity = AddEntity(update, "see-through");
  AddCubeAt(entity, -1.5, -1.5, 2, 0.4);
  AddCubeAt(entity, 1.5, 1.5, 2);
  SetSolid(*entity.add_spheres(), {-1.5, -1.5, 1}, {1, 1, 1}, {0.2, 0.7, 0.3, 1});
  auto& glass = *entity.add_cylinders();
  SetSolid(glass, {0, 0, 1}, {2, 2, 3}, {0.4, 0.6, 1, 0.35});
  glass.set_bottom_scale(1);
  glass.set_top_scale(0.6);
  Show("Scene", "scene", update);
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("scene_see_through");
}

TEST_F(EntityDisplayTest, DrawsTransparentChannelsFromBackToFront) {
  for (const double edge : {1.0, 3.0}) {  // One inside the other.
    const std::string channel = edge < 2 ? "inner" : "outer";
    Add("Scene", channel);
    SceneUpdate update = Cube(channel, edge);
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
  const auto set_axes = [](OvalShape& oval, double a, double b) {
    oval.set_a(a);
    oval.set_b(b);
  };
  auto& star = *add(2, 2).mutable_polygon();
  for (int i = 0; i < 10; ++i) {
    const double angle = std::numbers::pi * i / 5;
    const double radius = i % 2 == 0 ? 1 : 0.4;
    SetXy(*star.add_corners(), radius * std::cos(angle), radius * std::sin(angle));
  }
  set_axes(*add(-3, -1).mutable_oval(), 1, 0.5);
  SetXyz(*add(-0.5, -1).mutable_ellipsoid()->mutable_half_axes(), 0.9, 0.5, 0.5);
  auto& cone = *add(2, -1).mutable_cone();
  set_axes(*cone.mutable_base(), 0.8, 0.8);
  cone.set_height(1.5);
  auto& post = *add(-2, -3.5).mutable_extrusion();
  set_axes(*post.mutable_oval(), 0.5, 0.8);
  post.set_height(1);
  auto& wedge = *add(1, -3.5).mutable_extrusion();
  for (const auto& [x, y] : {std::array{-0.8, -0.8}, {0.8, -0.8}, {0.8, 0.8}, {0.0, 0.0}}) {
    SetXy(*wedge.mutable_polygon()->add_corners(), x, y);
  }
  wedge.set_height(1);
  Show("Shapes", "shapes", shapes);
  camera_.Zoom(1.6, 160, 120, kPictureSize);
  ExpectAsKept("shapes_of_the_paper");
}

TEST_F(EntityDisplayTest, RemovesExpiredEntitiesWithoutAMessage) {
  Display& display = Add("Scene", "scene");
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate update = Cube("short", 3);
  SceneEntity& entity = *update.mutable_entities(0);
  entity.mutable_timestamp()->set_seconds(session_.clock()->Now().nanoseconds / 1'000'000'000 - 100);
  entity.mutable_lifetime()->set_seconds(200);
  Send("scene", update, 1);
  EXPECT_GT(DifferentShare(empty, Draw()), 0.01);
  EXPECT_GT(display.next_change_s(), 1 + 98);
  EXPECT_LT(display.next_change_s(), 1 + 102);
  entity.mutable_lifetime()->set_seconds(50);
  Send("scene", update, 2);
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
    AddCubeAt(AddEntity(all, std::to_string(i)), i % 50 * 0.2 - 5, row * 0.2 - 4, 0.15);
  }
  Send("scene", all, 1);
  EXPECT_THAT(display.Status(), Contains(HasSubstr("2000 entities")));
  EXPECT_GT(DifferentShare(empty, Draw()), 0.1);
  for (int part = 0; part < 20; ++part) {
    SceneUpdate deletions;
    for (int i = part; i < 2000; i += 20) deletions.add_deletions()->set_id(std::to_string(i));
    Send("scene", deletions, 1 + 0.1 * part);
    (void)Draw();
  }
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
  EXPECT_THAT(display.Status().front(), HasSubstr("No entity"));
}

TEST_F(EntityDisplayTest, MovesOnlyEntitiesLockedToAFrame) {
  Display& display = Add("Scene", "scene");
  Move("base", 1'000);
  SceneUpdate update = Cube("cube", 2);
  SceneEntity& entity = *update.mutable_entities(0);
  entity.set_frame_id("base");
  for (const bool locked : {false, true}) {
    SCOPED_TRACE(locked);
    entity.set_frame_locked(locked);
    entity.mutable_timestamp()->set_nanos(locked ? 0 : 1'000);
    Send("scene", update, locked ? 10 : 0);
    const Pixels before = Draw();
    Move("base", locked ? 3'000 : 2'000, {0, locked ? 6.0 : 3.0, 0});
    Update(locked ? 11 : 1);
    EXPECT_EQ(DifferentShare(before, Draw()) > 0.01, locked);
    EXPECT_FALSE(display.HasFault());
  }
}

TEST_F(EntityDisplayTest, KeepsEntitiesWhereTheirFrameWasLongAgo) {
  Move("base", 1'000);
  SceneUpdate update = Cube("old", 2);
  update.mutable_entities(0)->set_frame_id("base");
  update.mutable_entities(0)->mutable_timestamp()->set_nanos(1'000);
  Show("Scene", "scene", update);
  const Pixels before = Draw();
  for (int s = 1; s <= 30; ++s) Move("base", s * 1'000'000'000L, {0, 5, 0});
  SceneUpdate other;
  AddCubeAt(AddEntity(other, "new"), 100, 100, 0.01);
  Publish("scene", other);
  Update(1);
  EXPECT_LT(DifferentShare(before, Draw()), 0.002);
}

TEST_F(EntityDisplayTest, ReportsAMissingTransformAndShowsEntitiesWithIt) {
  Display& display = Add("Scene", "scene");
  tree_.SetStatic("map", "other", RigidTransform());
  Update(0);
  const Pixels empty = Draw();
  SceneUpdate update = Cube("cube", 2);
  update.mutable_entities(0)->set_frame_id("arm");
  Send("scene", update);
  EXPECT_FALSE(display.HasFault()) << "it may still come";
  EXPECT_THAT(display.WaitsFor(), HasSubstr("arm"));
  EXPECT_EQ(display.next_change_s(), kLongestWaitS);
  Update(kLongestWaitS);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("arm"));
  EXPECT_EQ(DifferentShare(empty, Draw()), 0);
  SetStatic("map", "arm");
  Update(3);
  EXPECT_FALSE(display.HasFault());
  EXPECT_GT(DifferentShare(empty, Draw()), 0.01);
}

TEST_F(EntityDisplayTest, LooksTheSameMillionsOfMetersAway) {
  SceneUpdate there = EverySolid();
  there.mutable_entities(0)->set_frame_id("utm");
  ExpectTheSameFarAway(EverySolid(), there, RigidTransform({1, 0, 0, 0}, {500'000, 5'400'000, 256}), "Scene");
}

TEST_F(EntityDisplayTest, EntitiesTooFarAwayDoNotHideOthers) {
  Display& display = Show("Scene", "scene", EverySolid());
  const Pixels before = Draw();
  SceneUpdate far;
  AddCubeAt(AddEntity(far, "far"), 9e307, 0);
  AddCubeAt(AddEntity(far, "as far"), 9e307, 9e307);
  AddCubeAt(AddEntity(far, "in a far frame"), 0, 0);
  far.mutable_entities(2)->set_frame_id("nowhere");
  SetStatic("map", "nowhere", RigidTransform({1, 0, 0, 0}, {9e11, 0, 0}));
  Send("scene", far, 1);
  Update(1 + kLongestWaitS);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("Entity \"far\": 1 of its shapes"));
  EXPECT_THAT(display.Status(), Contains(HasSubstr("The frame nowhere is farther away")));
  EXPECT_EQ(DifferentShare(before, Draw()), 0);
  Send("scene", EverySolid(), 4);
  EXPECT_EQ(DifferentShare(before, Draw()), 0);
}

TEST_F(EntityDisplayTest, OneMalformedEntityLeavesTheBoundsOfTheOthers) {
  Display& display = Show("Scene", "scene", EverySolid());
  const Eigen::AlignedBox3d before = display.Bounds();
  for (const double size : {1e9, -1e9, 3e8, std::nan(""), HUGE_VAL}) {
    Send("scene", Cube("bad", size));
    EXPECT_TRUE(display.Bounds().isApprox(before)) << size << ": " << display.Bounds().sizes().transpose();
    EXPECT_TRUE(scene_.Bounds().isApprox(before)) << size;
  }
  Send("scene", Model("bad", 1, "vertex 0 0 0\nvertex 1e30 0 0\nvertex 0 1 0"));
  EXPECT_TRUE(display.Bounds().isApprox(before)) << "a corner of a mesh";
}

TEST_F(EntityDisplayTest, OneMalformedChannelLeavesTheBoundsOfTheOthers) {
  Show("Scene", "scene", EverySolid());
  Add("Scene", "bad");
  Add("Pose", "far");
  const Eigen::AlignedBox3d before = scene_.Bounds();
  Publish("bad", Cube("bad", 1e9));
  foxglove::PoseInFrame far;
  far.mutable_pose()->mutable_position()->set_x(1e30);
  Send("far", far);
  EXPECT_TRUE(scene_.Bounds().isApprox(before)) << scene_.Bounds().sizes().transpose();
}

TEST_F(EntityDisplayTest, ReturnsTextsAsLabelsWithPlaceAndColor) {
  SceneUpdate update;
  auto& text = *AddEntity(update, "text").add_texts();
  Place(*text.mutable_pose(), 1, 2, 3);
  text.set_text("kitchen");
  text.set_font_size(0.5);
  SetColor(*text.mutable_color(), 1, 0, 0);
  const std::vector<Label> labels = Show("Scene", "scene", update).Labels();
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
  Send("scene", Model("model", 3, "vertex -1 -1 0\nvertex 1 -1 0\nvertex 0 1 1"), 1);
  EXPECT_GT(DifferentShare(empty, Draw()), 0.02);
  EXPECT_NEAR(display.Bounds().max().z(), 3, 1e-6);
  EXPECT_FALSE(display.HasFault());
}

TEST_F(EntityDisplayTest, ReportsAMalformedMessage) {
  SceneUpdate update;
  AddCubeAt(AddEntity(update, "bad"), std::nan(""), 0);
  const Display& display = Show("Scene", "scene", update);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("\"bad\""));
  (void)Draw();
}

TEST_F(EntityDisplayTest, AppliesSettingsWhilePaused) {
  Display& display = Add("Scene", "scene");
  SceneUpdate update = Cube("cube", 3);
  update.mutable_entities(0)->set_frame_id("base");
  update.mutable_entities(0)->set_frame_locked(true);
  Move("base", 1'000'000'000);
  Send("scene", update);
  (void)Draw();
  Move("base", 2'000'000'000, {4, 0, 0});
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
