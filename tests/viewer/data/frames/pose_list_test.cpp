#include "viewer/data/frames/pose_list.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace hgros::viewer {
namespace {

std::vector<RigidTransform> Line(int count) {
  std::vector<RigidTransform> poses;
  for (int i = 0; i < count; ++i) poses.push_back({{1, 0, 0, 0}, {500'000.0 + i, 0, 0}});
  return poses;
}

TEST(PoseList, DistinguishesGrownFromRewrittenTrajectories) {
  PoseList list;
  EXPECT_EQ(list.Replace(Line(3)), PoseList::Change::kAppended);
  EXPECT_EQ(list.Replace(Line(3)), PoseList::Change::kNothing);
  EXPECT_EQ(list.Replace(Line(5)), PoseList::Change::kAppended);
  auto bent = Line(6);
  bent[1].translation.y() = 0.5;
  EXPECT_EQ(list.Replace(bent), PoseList::Change::kRewritten);
  EXPECT_EQ(list.poses().size(), 6U);
  EXPECT_FLOAT_EQ(list.poses()[1].position.y(), 0.5F);
  EXPECT_EQ(list.Replace(Line(2)), PoseList::Change::kRewritten);
  EXPECT_EQ(list.Replace({}), PoseList::Change::kRewritten);
  EXPECT_EQ(list.Replace({}), PoseList::Change::kNothing);
}

TEST(PoseList, IsRelativeToItsFirstPose) {
  PoseList list;
  (void)list.Replace(Line(2));
  EXPECT_EQ(list.origin().x(), 500'000);
  EXPECT_EQ(list.poses()[1].position.x(), 1);
}

TEST(PoseList, OmitsPosesThatAreNotNumbers) {
  auto poses = Line(3);
  poses[0].translation.x() = std::numeric_limits<double>::quiet_NaN();
  PoseList list;
  (void)list.Replace(poses);
  EXPECT_EQ(list.poses().size(), 2U);
  EXPECT_EQ(list.left_out(), 1U);
}

TEST(PoseList, KeepsTheLastPosesOfATrail) {
  PoseList list;
  for (const RigidTransform& pose : Line(5)) (void)list.Append(pose);
  EXPECT_EQ(list.KeepLast(5), PoseList::Change::kNothing);
  EXPECT_EQ(list.KeepLast(2), PoseList::Change::kRewritten);
  EXPECT_EQ(list.poses().front().position.x(), 3);
}

}  // namespace
}  // namespace hgros::viewer
