#include "viewer/data/robot/robot_links.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr const char* kArm =
    R"(<robot name="r"><link name="base"/><link name="arm"/><link name="hand"/><link name="eye"/>
  <joint name="arm_joint" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="grip" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="2 0 0"/></joint>
  <joint name="look" type="fixed"><parent link="base"/><child link="eye"/><origin xyz="0 0 3"/></joint>
</robot>)";

using Places = std::map<std::string, Eigen::Vector3d>;

PlacedLinks Placed(const Places& known, bool alone = false) {
  return PlaceLinks(
      ReadRobotLinks(kArm, ""),
      [&](const std::string& link) -> std::optional<Eigen::Isometry3d> {
        const auto found = known.find(link);
        if (found == known.end()) return std::nullopt;
        return Eigen::Isometry3d(Eigen::Translation3d(found->second));
      },
      alone);
}

void ExpectAt(const PlacedLinks& placed, const std::string& link, const Eigen::Vector3d& at) {
  const auto found = placed.T_fixed_link.find(link);
  ASSERT_NE(found, placed.T_fixed_link.end()) << link;
  EXPECT_LT((found->second.translation() - at).norm(), 1e-9) << link << ' ' << found->second.translation().transpose();
}

TEST(RobotLinks, WithoutATransformAreWhereTheDescriptionSays) {
  const PlacedLinks placed = Placed({{"base", {5, 0, 0}}});
  ExpectAt(placed, "arm", {6, 0, 0});
  ExpectAt(placed, "hand", {6, 2, 0});
  ExpectAt(placed, "eye", {5, 0, 3});
  EXPECT_THAT(placed.joints_at_zero, ElementsAre("arm_joint"));
}

TEST(RobotLinks, WithATransformMoveTheLinksBelowThem) {
  const PlacedLinks placed = Placed({{"base", {5, 0, 0}}, {"arm", {0, 0, 9}}});
  ExpectAt(placed, "arm", {0, 0, 9});
  ExpectAt(placed, "hand", {2, 0, 9});
  EXPECT_THAT(placed.joints_at_zero, IsEmpty());
}

TEST(RobotLinks, WithATransformMoveTheLinksAboveThem) {
  const PlacedLinks placed = Placed({{"eye", {0, 0, 3}}});
  ExpectAt(placed, "base", {0, 0, 0});
  ExpectAt(placed, "hand", {1, 2, 0});
}

TEST(RobotLinks, AreAtTheFixedFrameOnlyWithoutAnyTransforms) {
  EXPECT_THAT(Placed({}).T_fixed_link, IsEmpty());
  const PlacedLinks placed = Placed({}, true);
  EXPECT_EQ(placed.at_fixed_frame, "base");
  ExpectAt(placed, "eye", {0, 0, 3});
  EXPECT_EQ(Placed({{"eye", {0, 0, 0}}}, true).at_fixed_frame, "");
}

TEST(RobotLinks, AreReadOnceWithTheirPrefix) {
  const auto links = ReadRobotLinks(kArm, "left/");
  ASSERT_THAT(links, SizeIs(4));
  EXPECT_EQ(links.front().name, "left/base");
  for (std::size_t i = 1; i < links.size(); ++i) EXPECT_LT(links[i].parent.value_or(i), i);
  EXPECT_THAT(ReadRobotLinks("<robot", ""), IsEmpty());
  EXPECT_LE(ReadRobotLinks(R"(<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="1" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="2" type="fixed"><parent link="b"/><child link="c"/></joint>
    <joint name="3" type="fixed"><parent link="c"/><child link="b"/></joint></robot>)",
                           "")
                .size(),
            3U);
}

}  // namespace
}  // namespace hgros::viewer
