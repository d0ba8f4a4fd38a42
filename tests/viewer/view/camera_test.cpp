#include "viewer/view/camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace hgros::viewer {
namespace {

constexpr Viewport kViewport{800, 600};

void ExpectNear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance) {
  EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " is not " << b.transpose();
}

/// Checks where a point is in the picture.
void ExpectAt(const Camera& camera, const Eigen::Vector3d& point, double x, double y) {
  const Eigen::Vector3d pixel = camera.PixelOf(point, kViewport).value();
  EXPECT_NEAR(pixel.x(), x, 1e-6);
  EXPECT_NEAR(pixel.y(), y, 1e-6);
}

TEST(Camera, LooksAtTheOriginFromTheStart) { ExpectAt(Camera(), Eigen::Vector3d::Zero(), 400, 300); }

class CameraOfEachKind : public ::testing::TestWithParam<bool> {
 protected:
  CameraOfEachKind() { camera_.SetOrthographic(GetParam()); }
  Camera camera_;
};
INSTANTIATE_TEST_SUITE_P(Kinds, CameraOfEachKind, ::testing::Bool(),
                         [](const auto& kind) { return kind.param ? "orthographic" : "perspective"; });

TEST_P(CameraOfEachKind, ConvertsPixelsToPointsAndBack) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> meters(-5, 5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(meters(random), meters(random), meters(random));
    const Eigen::Vector3d pixel = camera_.PixelOf(point, kViewport).value();
    ExpectNear(camera_.PointAt(pixel.x(), pixel.y(), pixel.z(), kViewport), point, 1e-6);
  }
}

TEST(Camera, OrbitingKeepsTheAnchorInPlace) {
  Camera camera;
  const Eigen::Vector3d anchor(2, -1, 0.5);
  const Eigen::Vector3d before = camera.PixelOf(anchor, kViewport).value();
  camera.SetAnchor(anchor);
  camera.Orbit(0.7, 0.2);
  camera.Turn(0.3, -0.1, 0.4);
  // The direction to the anchor turns with the camera, so its pixel stays.
  ExpectAt(camera, anchor, before.x(), before.y());
}

TEST(Camera, OrbitingKeepsTheHorizonLevelAndStopsAtThePoles) {
  Camera camera;
  for (int i = 0; i < 50; ++i) {
    camera.Orbit(0.3, 0.2);
    EXPECT_NEAR((camera.orientation() * Eigen::Vector3d::UnitX()).z(), 0, 1e-9);
    EXPECT_GE((camera.orientation() * Eigen::Vector3d::UnitY()).z(), 0);
  }
  for (int i = 0; i < 50; ++i) camera.Orbit(0, -0.2);
  EXPECT_GE((camera.orientation() * Eigen::Vector3d::UnitY()).z(), 0);
}

TEST_P(CameraOfEachKind, ZoomsTowardThePointerOrTheAnchor) {
  const Eigen::Vector3d pivot = camera_.Pivot();
  const Eigen::Vector3d beside = pivot + camera_.orientation() * Eigen::Vector3d(3, 1, 0);
  const Eigen::Vector3d pixel = camera_.PixelOf(beside, kViewport).value();
  camera_.Zoom(2, pixel.x(), pixel.y(), kViewport);
  ExpectAt(camera_, beside, pixel.x(), pixel.y());
  EXPECT_NEAR(camera_.distance(), 10, 1e-9);

  camera_.SetAnchor(pivot);
  const Eigen::Vector3d anchored = camera_.PixelOf(pivot, kViewport).value();
  camera_.Zoom(0.5, 0, 0, kViewport);
  ExpectAt(camera_, pivot, anchored.x(), anchored.y());
}

TEST_P(CameraOfEachKind, PanningMovesThePivotWithThePointer) {
  const Eigen::Vector3d pivot = camera_.Pivot();
  camera_.Pan(50, -20, kViewport);
  ExpectAt(camera_, pivot, 450, 280);
}

TEST(Camera, FromAboveHasXRightAndYUpAndKeepsTheMiddle) {
  Camera camera;
  const Eigen::Vector3d pivot = camera.Pivot();
  camera.LookFromAbove();
  ExpectNear(camera.Pivot(), pivot, 1e-9);
  ExpectNear(camera.orientation() * -Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ(), 1e-9);
  const Viewport viewport{400, 300};
  const Eigen::Vector3d right = camera.PixelOf(pivot + Eigen::Vector3d::UnitX(), viewport).value();
  const Eigen::Vector3d up = camera.PixelOf(pivot + Eigen::Vector3d::UnitY(), viewport).value();
  EXPECT_GT(right.x(), 201);
  EXPECT_NEAR(right.y(), 150, 1e-6);
  EXPECT_NEAR(up.x(), 200, 1e-6);
  EXPECT_LT(up.y(), 149);
  camera.LookFromAbove();  // A second call has no effect.
  ExpectNear(camera.Pivot(), pivot, 1e-9);
}

TEST(Camera, FollowsAPositionOrAPose) {
  const RigidTransform before({1, 0, 0, 0}, {1, 2, 0});
  const RigidTransform now(RigidTransform::Rotation(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ())), {4, 2, 0});
  Camera position;
  const Eigen::Vector3d eye = position.eye();
  position.Follow(before, now, false);
  ExpectNear(position.eye(), eye + Eigen::Vector3d(3, 0, 0), 1e-12);

  Camera pose;
  pose.SetAnchor(Eigen::Vector3d(1, 1, 1));
  const Eigen::Vector3d pixel = pose.PixelOf(*pose.anchor(), kViewport).value();
  pose.Follow(before, now, true);
  EXPECT_NEAR(pose.PixelOf(*pose.anchor(), kViewport).value().x(), pixel.x(), 1e-6);
  ExpectNear(before.Inverse() * eye, now.Inverse() * pose.eye(), 1e-9);
}

TEST(Camera, CentersAPointWithoutTurningOrZooming) {
  Camera camera;
  camera.Orbit(0.3, 0.1);
  const Eigen::Quaterniond turned = camera.orientation();
  const Eigen::Vector3d there(300, -40, 2);
  camera.Center(there);
  ExpectAt(camera, there, 400, 300);
  EXPECT_NEAR((camera.eye() - there).norm(), camera.distance(), 1e-9);
  EXPECT_TRUE(camera.orientation().isApprox(turned));
}

TEST(Camera, DrawsCoordinatesOfMillionsOfMetersExactly) {
  Camera near_origin;
  Camera far_away;
  const Eigen::Vector3d there(500'000, 5'400'000, 300);
  far_away.Focus(there, std::tan(std::numbers::pi / 8) * 20);
  const Eigen::Vector3d point(1.234, -0.567, 0.25);
  const Eigen::Vector3d here = near_origin.PixelOf(point, kViewport).value();
  const ViewMatrices view = far_away.Matrices(kViewport);
  // As the GPU does it: float differences to the eye.
  const Eigen::Vector3f from_eye = (there + point - view.eye).cast<float>();
  const Eigen::Vector4f clip = view.clip_from_eye * from_eye.homogeneous();
  EXPECT_NEAR((clip.x() / clip.w() + 1) / 2 * 800, here.x(), 1e-2);
  EXPECT_NEAR((1 - clip.y() / clip.w()) / 2 * 600, here.y(), 1e-2);
}

TEST_P(CameraOfEachKind, FitsABoxIntoThePictureOrAPartOfIt) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(100, -3, 0), Eigen::Vector3d(160, 9, 25));
  for (const PixelArea& room : {PixelArea{0, 0, 800, 600}, {500, 50, 280, 300}}) {
    camera_.Focus(box, kViewport, room);
    double widest = 0;
    for (int i = 0; i < 8; ++i) {
      const auto pixel = camera_.PixelOf(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)), kViewport);
      ASSERT_TRUE(pixel);
      widest = std::max({widest, std::abs(2 * (pixel->x() - room.x) / room.width - 1),
                         std::abs(2 * (pixel->y() - room.y) / room.height - 1)});
    }
    EXPECT_LE(widest, 1) << room.width;
    EXPECT_GT(widest, 0.7) << room.width;
  }
}

TEST(Camera, IgnoresTargetsThatAreNotFinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kLargest = std::numeric_limits<double>::max();
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  const Eigen::AlignedBox3d boxes[] = {
      {one, kInfinity * one}, {-kInfinity * one, one}, {-kLargest * one, kLargest * one}};
  for (const Eigen::AlignedBox3d& box : boxes) {
    Camera camera;
    camera.Focus(box, kViewport);
    EXPECT_TRUE(camera.SameViewAs(Camera()));
  }
  Camera camera;
  camera.Focus(Eigen::AlignedBox3d(1e20 * one, 1.1e20 * one), kViewport);
  EXPECT_LT(camera.eye().cwiseAbs().maxCoeff(), 1e12) << "the limit of numbers in a layout";
}

TEST(Camera, ZoomingHasLimits) {
  Camera camera;
  for (int i = 0; i < 1000; ++i) camera.Zoom(10, 400, 300, kViewport);
  EXPECT_GT(camera.distance(), 0);
  for (int i = 0; i < 1000; ++i) camera.Zoom(0.1, 400, 300, kViewport);
  EXPECT_TRUE(std::isfinite(camera.distance()));
  EXPECT_TRUE(camera.eye().allFinite());
}

}  // namespace
}  // namespace hgros::viewer
