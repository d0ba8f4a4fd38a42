#include <gtest/gtest.h>

#include "viewer/view/navigation.hpp"
#include "viewer/view/point_picks.hpp"

namespace hgros::viewer {
namespace {

constexpr Viewport kWindow{800, 600};

class NavigationTest : public ::testing::Test {
 protected:
  /// Returns what a click picks.
  std::optional<Eigen::Vector2d> Drag(PointerButton button, double x, double y) {
    navigation_.OnPress(button, 100, 100);
    navigation_.OnPointer(x, y, kWindow);
    return navigation_.OnRelease(button, x, y);
  }

  Camera camera_;
  Navigation navigation_{camera_};
};

TEST_F(NavigationTest, ALeftClickPicksAndALeftDragOrbits) {
  EXPECT_EQ(Drag(PointerButton::kLeft, 101, 101), Eigen::Vector2d(101, 101));
  EXPECT_TRUE(camera_.SameViewAs(Camera()));

  EXPECT_FALSE(Drag(PointerButton::kLeft, 150, 100));
  EXPECT_FALSE(camera_.SameViewAs(Camera()));
  EXPECT_NEAR((camera_.Pivot()).norm(), 0, 1e-9);
}

TEST_F(NavigationTest, ARightDragPans) {
  EXPECT_FALSE(Drag(PointerButton::kRight, 150, 100));
  EXPECT_GT(camera_.Pivot().norm(), 0.1);
  EXPECT_TRUE(camera_.orientation().coeffs() == Camera().orientation().coeffs());
}

TEST_F(NavigationTest, MovingWithoutAButtonChangesNothing) {
  navigation_.OnPointer(10, 10, kWindow);
  navigation_.OnPointer(500, 500, kWindow);
  EXPECT_TRUE(camera_.SameViewAs(Camera()));
}

TEST_F(NavigationTest, TheWheelZoomsInAndOut) {
  navigation_.OnPointer(400, 300, kWindow);
  navigation_.OnWheel(2, kWindow);
  EXPECT_LT(camera_.distance(), 20);
  navigation_.OnWheel(-2, kWindow);
  EXPECT_NEAR(camera_.distance(), 20, 1e-9);
}

TEST_F(NavigationTest, KeysTurnBackAndForth) {
  for (const auto& [there, back] : {std::pair{CameraKey::kYawLeft, CameraKey::kYawRight},
                                    {CameraKey::kPitchUp, CameraKey::kPitchDown},
                                    {CameraKey::kRollLeft, CameraKey::kRollRight},
                                    {CameraKey::kForward, CameraKey::kBack},
                                    {CameraKey::kLeft, CameraKey::kRight},
                                    {CameraKey::kUp, CameraKey::kDown}}) {
    navigation_.OnKey(there);
    EXPECT_FALSE(camera_.SameViewAs(Camera()));
    navigation_.OnKey(back);
    EXPECT_LT((camera_.eye() - Camera().eye()).norm(), 1e-9);
  }
}

PickedPoint At(double x, double y, double z) {
  PickedPoint point;
  point.at = {x, y, z};
  return point;
}

TEST(PointPicks, MeasuresFromTheFirstToTheSecond) {
  PointPicks picks;
  picks.Add(At(1, 1, 1));
  EXPECT_FALSE(picks.measurement()) << "one point alone has no distance";
  picks.Add(At(4, 5, 13));
  const Measurement measured = picks.measurement().value();
  EXPECT_EQ(measured.step, Eigen::Vector3d(3, 4, 12));
  EXPECT_DOUBLE_EQ(measured.distance, 13);
  EXPECT_DOUBLE_EQ(measured.in_plane, 5);
}

TEST(PointPicks, StartsAgainWithTheThirdPoint) {
  PointPicks picks;
  for (int i = 0; i < 3; ++i) picks.Add(At(i, 0, 0));
  ASSERT_EQ(picks.points().size(), 1U);
  EXPECT_EQ(picks.points()[0].at.x(), 2);
  picks.Clear();
  EXPECT_TRUE(picks.points().empty());
}

TEST(PointPicks, MeasuresExactlyFarFromTheOrigin) {
  PointPicks picks;
  picks.Add(At(500'000.125, 5'400'000.5, 300));
  picks.Add(At(500'000.250, 5'400'000.5, 300));
  EXPECT_DOUBLE_EQ(picks.measurement()->distance, 0.125);
}

TEST(PointPicks, WritesMetersWithSuitableDecimals) {
  EXPECT_EQ(MetersText(Eigen::Vector3d(1.23456, -2, 0)), "1.235, -2.000, 0.000 m");
  EXPECT_EQ(MetersText(Eigen::Vector3d(500000.127, 5400000.5, 300)), "500000.1, 5400000.5, 300.0 m");
  EXPECT_EQ(MetersText(12.5), "12.500 m");
}

}  // namespace
}  // namespace hgros::viewer
