// drive_test.cpp: tests Drive without a robot, and without waiting.
#include "drive.cpp"

#include <cstdio>

#include <hgros/testing/harness.hpp>

int main() {
  hgros::testing::Harness<Drive> drive({.params = "max_speed_mps: 0.2"});
  foxglove::Vector3 velocity;
  velocity.set_x(1);
  drive.Feed("velocity", velocity);
  drive.Step(std::chrono::seconds(10));
  const auto odometry = drive.Take<foxglove::Odometry>("odometry");
  const double x = odometry.back()->pose().position().x();
  std::printf("x = %.2f m after %zu steps\n", x, odometry.size());
  return std::abs(x - 0.2 * 0.5) < 0.01 ? 0 : 1;  // It stopped after 0.5 s.
}
