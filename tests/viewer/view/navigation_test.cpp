#include "viewer/view/navigation.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

constexpr Viewport kWindow{800, 600};

TEST(Navigation, ALeftClickPicksAndALeftDragOrbits) {
  Camera camera;
  Navigation navigation(camera);
  navigation.OnPress(PointerButton::kLeft, 100, 100);
  navigation.OnPointer(101, 101, kWindow);
  const auto picked = navigation.OnRelease(PointerButton::kLeft, 101, 101);
  ASSERT_TRUE(picked);
  EXPECT_EQ(*picked, Eigen::Vector2d(101, 101));
  EXPECT_TRUE(camera.SameViewAs(Camera()));

  navigation.OnPress(PointerButton::kLeft, 100, 100);
  navigation.OnPointer(150, 100, kWindow);
  EXPECT_FALSE(navigation.OnRelease(PointerButton::kLeft, 150, 100));
  EXPECT_FALSE(camera.SameViewAs(Camera()));
  EXPECT_NEAR((camera.Pivot()).norm(), 0, 1e-9);
}

TEST(Navigation, ARightDragPans) {
  Camera camera;
  Navigation navigation(camera);
  navigation.OnPress(PointerButton::kRight, 100, 100);
  navigation.OnPointer(150, 100, kWindow);
  EXPECT_FALSE(navigation.OnRelease(PointerButton::kRight, 150, 100));
  EXPECT_GT(camera.Pivot().norm(), 0.1);
  EXPECT_TRUE(camera.orientation().coeffs() == Camera().orientation().coeffs());
}

TEST(Navigation, MovingWithoutAButtonChangesNothing) {
  Camera camera;
  Navigation navigation(camera);
  navigation.OnPointer(10, 10, kWindow);
  navigation.OnPointer(500, 500, kWindow);
  EXPECT_TRUE(camera.SameViewAs(Camera()));
}

TEST(Navigation, TheWheelZoomsInAndOut) {
  Camera camera;
  Navigation navigation(camera);
  navigation.OnPointer(400, 300, kWindow);
  navigation.OnWheel(2, kWindow);
  EXPECT_LT(camera.distance(), 20);
  navigation.OnWheel(-2, kWindow);
  EXPECT_NEAR(camera.distance(), 20, 1e-9);
}

TEST(Navigation, KeysTurnBackAndForth) {
  Camera camera;
  Navigation navigation(camera);
  for (const auto& [there, back] : {std::pair{CameraKey::kYawLeft, CameraKey::kYawRight},
                                    {CameraKey::kPitchUp, CameraKey::kPitchDown},
                                    {CameraKey::kRollLeft, CameraKey::kRollRight},
                                    {CameraKey::kForward, CameraKey::kBack},
                                    {CameraKey::kLeft, CameraKey::kRight},
                                    {CameraKey::kUp, CameraKey::kDown}}) {
    navigation.OnKey(there);
    EXPECT_FALSE(camera.SameViewAs(Camera()));
    navigation.OnKey(back);
    EXPECT_LT((camera.eye() - Camera().eye()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace hgros::viewer
