// Each component is one source without a header, as the tutorial writes it.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>

#include <hgros/testing/harness.hpp>

#include "drive.cpp"
#include "watch.cpp"

namespace {

using foxglove::Odometry;
using foxglove::Vector3;
using hgros::testing::Harness;
using std::chrono::milliseconds;

Vector3 Velocity(double speed, double turn) {
  Vector3 velocity;
  velocity.set_x(speed);
  velocity.set_z(turn);
  return velocity;
}

std::shared_ptr<const Odometry> LastOf(Harness<Drive>& drive) { return drive.Take<Odometry>("odometry").back(); }

double HeadingOf(const Odometry& odometry) {
  return 2 * std::atan2(odometry.pose().orientation().z(), odometry.pose().orientation().w());
}

TEST(Drive, FollowsAVelocityUntilTheTimeout) {
  Harness<Drive> drive({.params = "timeout: 1s"});
  drive.Feed("velocity", Velocity(0.4, 0));
  drive.Step(milliseconds(1000));
  EXPECT_EQ(LastOf(drive)->linear_velocity().x(), 0.4);
  drive.Step(milliseconds(1000));
  const auto odometry = LastOf(drive);
  EXPECT_EQ(odometry->linear_velocity().x(), 0);
  EXPECT_NEAR(odometry->pose().position().x(), 0.4, 1e-9);
  EXPECT_EQ(odometry->pose().position().y(), 0);
}

TEST(Drive, IsNotFasterThanItsLimitsWhichMayChange) {
  Harness<Drive> drive;
  drive.Feed("velocity", Velocity(-9, 9));
  drive.Step(milliseconds(20));
  EXPECT_EQ(LastOf(drive)->linear_velocity().x(), -0.5);
  ASSERT_TRUE(drive.params().Set("max_turn_radps", 0.5).ok());
  drive.Step(milliseconds(20));
  EXPECT_EQ(LastOf(drive)->angular_velocity().z(), 0.5);
}

TEST(Drive, DrivesWhereItIsTurnedTo) {
  Harness<Drive> drive({.params = "{max_turn_radps: 4, timeout: 1s}"});
  drive.Feed("velocity", Velocity(0, std::numbers::pi / 2));
  drive.Step(milliseconds(1000));
  EXPECT_NEAR(HeadingOf(*LastOf(drive)), std::numbers::pi / 2, 1e-9);
  drive.Feed("velocity", Velocity(0.5, 0));
  drive.Step(milliseconds(1000));
  const auto odometry = LastOf(drive);
  EXPECT_NEAR(odometry->pose().position().x(), 0, 1e-9);
  EXPECT_NEAR(odometry->pose().position().y(), 0.5, 1e-9);
}

TEST(Drive, GoesOnFromASavedState) {
  Harness<Drive> first;
  first.Feed("velocity", Velocity(0.5, 1));
  first.Step(milliseconds(400));
  Harness<Drive> second({.state = first.Save()});
  second.Step(milliseconds(20));
  const auto before = LastOf(first);
  const auto after = LastOf(second);
  EXPECT_EQ(after->pose().position().x(), before->pose().position().x());
  EXPECT_EQ(after->pose().position().y(), before->pose().position().y());
  EXPECT_NEAR(HeadingOf(*after), HeadingOf(*before), 1e-12);
}

Odometry At(double x, double heading, double speed) {
  Odometry odometry;
  odometry.mutable_pose()->mutable_position()->set_x(x);
  odometry.mutable_pose()->mutable_orientation()->set_z(std::sin(heading / 2));
  odometry.mutable_pose()->mutable_orientation()->set_w(std::cos(heading / 2));
  odometry.mutable_linear_velocity()->set_x(speed);
  return odometry;
}

// The speed that is passed on when this one is wanted.
double Passed(Harness<Watch>& watch, double wanted) {
  watch.Feed("wanted", Velocity(wanted, 1));
  const auto velocity = watch.Take<Vector3>("velocity").back();
  EXPECT_EQ(velocity->z(), 1);
  return velocity->x();
}

TEST(Watch, PassesOnlyTurnsUntilItKnowsWhereTheRobotIsAndThenWhatStaysInsideTheCircle) {
  Harness<Watch> watch;
  EXPECT_EQ(Passed(watch, 0.4), 0);
  watch.Feed("odometry", At(0.9, 0, 0.4));
  EXPECT_EQ(Passed(watch, 0.4), 0.4);
  EXPECT_TRUE(watch.lines().empty());
}

TEST(Watch, PassesAtTheEdgeOnlyWhatLeadsBack) {
  Harness<Watch> watch;
  watch.Feed("odometry", At(1.1, 0, 0));
  EXPECT_EQ(Passed(watch, 0.4), 0);
  EXPECT_EQ(Passed(watch, -0.4), -0.4);
  watch.Feed("odometry", At(1.1, std::numbers::pi, 0));
  EXPECT_EQ(Passed(watch, 0.4), 0.4);
  EXPECT_EQ(Passed(watch, -0.4), 0);
}

TEST(Watch, StopsARobotThatDrivesOutWithoutBeingAskedTo) {
  Harness<Watch> watch({.params = "radius_m: 2"});
  watch.Feed("odometry", At(1.9, 0, 0.4));
  EXPECT_TRUE(watch.Take<Vector3>("velocity").empty());
  watch.Feed("odometry", At(2, 0, 0.4));
  ASSERT_EQ(watch.Take<Vector3>("velocity").size(), 1U);
  ASSERT_EQ(watch.lines().size(), 1U);
  EXPECT_EQ(watch.lines().front(), "The robot stops at the edge of its circle.");
}

}  // namespace
