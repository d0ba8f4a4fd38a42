#include "relations_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "support/scratch_folder.hpp"
#include "trajectory_file.hpp"

namespace slam2d {
namespace {

ScanMatch At(double stamp, const Pose2& pose) { return {.stamp_seconds = stamp, .T_map_laser = pose}; }

TEST(RelationsError, EqualsTheValuesComputedByHand) {
  // The robot faces +y, so 2 m further in y are 2 m straight ahead.
  const std::vector<ScanMatch> trajectory{At(1.0, {5.0, 5.0, M_PI / 2}), At(2.0, {5.0, 7.0, M_PI / 2}),
                                          At(3.0, {4.0, 7.0, M_PI / 2 + 0.1})};
  const std::vector<Relation> relations{
      {1.0, 2.0, {1.5, 0.0, 0.0}},   // 0.5 m off.
      {2.0, 3.0, {0.0, 1.0, 0.0}},   // 0.1 rad off.
      {1.0, 99.0, {0.0, 0.0, 0.0}},  // No such stamp.
  };
  const RelationsError error = CompareWithRelations(trajectory, relations);
  EXPECT_EQ(error.relations, 2U);
  EXPECT_EQ(error.unmatched, 1U);
  EXPECT_NEAR(error.mean_translation_m, 0.25, 1e-12);
  EXPECT_NEAR(error.std_translation_m, 0.25, 1e-12);
  EXPECT_NEAR(error.max_translation_m, 0.5, 1e-12);
  EXPECT_NEAR(error.mean_rotation_rad, 0.05, 1e-12);
  EXPECT_NEAR(error.std_rotation_rad, 0.05, 1e-12);
}

TEST(RelationsError, UsesTheNearestStampWithinTheTolerance) {
  const std::vector<ScanMatch> trajectory{At(1.0, {}), At(1.008, {1.0, 0.0, 0.0}), At(2.0, {3.0, 0.0, 0.0})};
  const std::vector<Relation> relations{{1.006, 2.001, {2.0, 0.0, 0.0}}};
  EXPECT_NEAR(CompareWithRelations(trajectory, relations).mean_translation_m, 0.0, 1e-12);
  EXPECT_EQ(CompareWithRelations(trajectory, relations, 1e-4).unmatched, 1U);
}

TEST(RelationsError, ReadsRelationsAndNamesABadLine) {
  const hgros::test::ScratchFolder folder;
  const auto good = ReadRelations(folder.Write("good", "1.5 2.5 0.1 0.2 0 0 0 0.3\n\n"));
  ASSERT_EQ(good.size(), 1U);
  EXPECT_EQ(good[0].stamp_2_seconds, 2.5);
  EXPECT_EQ(good[0].T_1_2, (Pose2{0.1, 0.2, 0.3}));
  try {
    (void)ReadRelations(folder.Write("bad", "1 2 0 0 0 0 0 0\n1 2 oops\n"));
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("bad:2:"), std::string::npos) << error.what();
  }
  EXPECT_THROW((void)ReadRelations(folder / "missing"), std::runtime_error);
}

TEST(TrajectoryFile, ReadsBackExactly) {
  const hgros::test::ScratchFolder folder;
  const ScanMatch match = At(976052890.21347904, {0.1 + 0.2, -1.0 / 3.0, 2.5});
  WriteTrajectory(std::vector{match, match}, folder / "trajectory.txt");
  std::ifstream file(folder / "trajectory.txt");
  for (int line = 0; line < 2; ++line) {
    double v[8];
    for (double& number : v) ASSERT_TRUE(file >> number);
    const double expected[] = {match.stamp_seconds, match.T_map_laser.x, match.T_map_laser.y, 0, 0, 0,
                               std::sin(1.25),      std::cos(1.25)};
    for (int i = 0; i < 8; ++i) EXPECT_EQ(v[i], expected[i]) << i;
  }
  double more = 0.0;
  EXPECT_FALSE(file >> more);
}

TEST(TrajectoryFile, ThrowsASentenceIfItCannotBeWritten) {
  const hgros::test::ScratchFolder folder;
  EXPECT_THROW(WriteTrajectory({}, folder / "missing/trajectory.txt"), std::runtime_error);
}

}  // namespace
}  // namespace slam2d
