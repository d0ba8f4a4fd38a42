#include "trajectory_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "temporary_folder.hpp"

namespace slam2d {
namespace {

TEST(TrajectoryFile, ReadsBackExactly) {
  const TemporaryFolder folder;
  ScanMatch match;
  match.stamp_seconds = 976052890.21347904;
  match.T_map_laser = {0.1 + 0.2, -1.0 / 3.0, 2.5};
  WriteTrajectory(std::vector{match, match}, folder / "trajectory.txt");
  std::ifstream file(folder / "trajectory.txt");
  for (int line = 0; line < 2; ++line) {
    double v[8];
    for (double& number : v) ASSERT_TRUE(file >> number);
    EXPECT_EQ(v[0], match.stamp_seconds);
    EXPECT_EQ(v[1], match.T_map_laser.x);
    EXPECT_EQ(v[2], match.T_map_laser.y);
    EXPECT_EQ(v[3], 0.0);
    EXPECT_EQ(v[4], 0.0);
    EXPECT_EQ(v[5], 0.0);
    EXPECT_EQ(v[6], std::sin(1.25));
    EXPECT_EQ(v[7], std::cos(1.25));
  }
  double more = 0.0;
  EXPECT_FALSE(file >> more);
}

TEST(TrajectoryFile, ThrowsASentenceIfItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteTrajectory({}, folder / "missing/trajectory.txt"), std::runtime_error);
}

}  // namespace
}  // namespace slam2d
