// Robots from their descriptions, and real trajectories. Tests that need recorded data are skipped without
// HGROS_DATA.

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <foxglove/JointStates.pb.h>

#include "hgros/base/error.hpp"
#include "hgros/tf/robot_description.hpp"
#include "hgros/tf/transform_tree.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using test::Difference;
using test::Shift;
using test::TurnZ;

std::filesystem::path Recorded(const std::string& name) {
  const char* folder = std::getenv("HGROS_DATA");
  if (folder == nullptr || !std::filesystem::exists(std::filesystem::path(folder) / name)) return {};
  return std::filesystem::path(folder) / name;
}

constexpr const char* kSmallRobot = R"(<robot name="small">
  <link name="base"/><link name="mast"/><link name="head"/><link name="lift"/><link name="finger"/>
  <joint name="mast_joint" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 1"/></joint>
  <joint name="head_pan" type="continuous"><parent link="mast"/><child link="head"/><origin xyz="0.5 0 0"/>
    <axis xyz="0 0 2"/></joint>
  <joint name="lift_joint" type="prismatic"><parent link="base"/><child link="lift"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  <joint name="finger_joint" type="prismatic"><parent link="lift"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="lift_joint" multiplier="-2" offset="0.5"/></joint>
</robot>)";

TEST(RobotDescription, MakesStaticEdgesOfFixedJointsAndMovesTheOthers) {
  const RobotDescription robot = RobotDescription::FromText(kSmallRobot, "robot1/");
  EXPECT_EQ(robot.root(), "robot1/base");
  EXPECT_EQ(robot.joints(), (std::vector<std::string>{"head_pan", "lift_joint"}));
  TransformTree tree;
  ASSERT_TRUE(robot.SetFixed(tree));
  foxglove::JointStates states;
  states.mutable_timestamp()->set_seconds(3);
  states.mutable_timestamp()->set_nanos(5);
  for (const auto& [name, position] :
       {std::pair("head_pan", 0.7), std::pair("lift_joint", 0.2), std::pair("wheel", 9.0)}) {
    auto& joint = *states.add_joints();
    joint.set_name(name);
    joint.set_position(position);
  }
  ASSERT_TRUE(robot.SetJoints(tree, states));
  const Time stamp{3'000'000'005};
  EXPECT_LT(
      Difference(tree.Lookup("robot1/base", "robot1/head", stamp)->T_target_source, Shift(0.5, 0, 1) * TurnZ(0.7)),
      1e-12);
  EXPECT_LT(Difference(tree.Lookup("robot1/base", "robot1/finger", stamp)->T_target_source, Shift(0.2, 0.1)), 1e-12);
}

TEST(RobotDescription, RefusesJointStatesWithAnInvalidStamp) {
  const RobotDescription robot = RobotDescription::FromText(kSmallRobot);
  for (const auto& [seconds, nanos] : {std::pair(INT64_MAX, 0), std::pair(INT64_MIN, 0), std::pair(INT64_C(1), -1),
                                       std::pair(INT64_C(9'223'372'036), 999'999'999)}) {
    foxglove::JointStates states;
    states.mutable_timestamp()->set_seconds(seconds);
    states.mutable_timestamp()->set_nanos(nanos);
    auto& joint = *states.add_joints();
    joint.set_name("head_pan");
    TransformTree tree;
    const SetResult result = robot.SetJoints(tree, states);
    EXPECT_FALSE(result);
    EXPECT_EQ(result.text(), "The joint states were refused: their timestamp is invalid.");
    EXPECT_TRUE(tree.Edges().empty());
    EXPECT_THROW((void)robot.EdgesAt(states), Error);
  }
}

TEST(RobotDescription, RefusesInvalidUrdf) {
  EXPECT_THROW((void)RobotDescription::FromText("no robot"), Error);
  EXPECT_THROW((void)RobotDescription::FromText("<robot name='r'><link name='a'/><joint"), Error);
  EXPECT_THROW((void)RobotDescription::FromFile("/nowhere/robot.urdf"), Error);
  EXPECT_THROW((void)RobotDescription::FromText(
                   R"(<robot name="r"><link name="a"/><link name="b"/>
                      <joint name="j" type="floating"><parent link="a"/><child link="b"/></joint></robot>)"),
               Error);
}

// LeakSanitizer reports the links if a cycle of them is not freed.
TEST(RobotDescription, FreesJointsThatFormACycle) {
  const std::string beside = R"(<robot name="r"><link name="base"/><link name="a"/><link name="b"/>
    <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint>)";
  const std::string below = R"(<parent link="base"/><child link="a"/></joint></robot>)";
  for (const std::string& urdf : {beside + "</robot>", beside + R"(<joint name="j" type="fixed">)" + below}) {
    const RobotDescription robot = RobotDescription::FromText(urdf);
    EXPECT_EQ(robot.root(), "base");
    TransformTree tree;
    EXPECT_FALSE(robot.SetFixed(tree)) << "a tree has no cycles";
  }
  EXPECT_THROW((void)RobotDescription::FromText(beside + R"(<joint name="j" type="floating">)" + below), Error);
}

struct StampedPose {
  Time stamp;
  RigidTransform pose;
};

std::vector<StampedPose> ReadKitti() {
  std::ifstream poses(Recorded("trajectories/kitti_00_gt.txt"));
  std::ifstream times(Recorded("trajectories/kitti_00_times.txt"));
  std::vector<StampedPose> trajectory;
  double seconds = 0;
  while (times >> seconds) {
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> pose;
    for (Eigen::Index i = 0; i < 12; ++i) poses >> pose.data()[i];
    RigidTransform::Rotation rotation(Eigen::Matrix3d(pose.leftCols<3>()));
    rotation.normalize();
    trajectory.push_back({Time{std::llround(seconds * 1e9)}, {rotation, pose.col(3)}});
  }
  return trajectory;
}

std::vector<StampedPose> ReadTum() {
  std::ifstream file(Recorded("trajectories/tum_fr2_desk_gt.txt"));
  std::vector<StampedPose> trajectory;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string stamp;
    double x, y, z, qx, qy, qz, qw;
    words >> stamp >> x >> y >> z >> qx >> qy >> qz >> qw;
    const std::size_t dot = stamp.find('.');
    const std::int64_t fraction = std::stoll((stamp.substr(dot + 1) + "000000000").substr(0, 9));
    trajectory.push_back({Time{std::stoll(stamp.substr(0, dot)) * 1'000'000'000 + fraction},
                          {RigidTransform::Rotation(qw, qx, qy, qz), Eigen::Vector3d(x, y, z)}});
  }
  return trajectory;
}

// Moves the Fetch robot along a trajectory with its arm moving. Compares its gripper's pose with the product of the
// parts.
void DriveFetch(const std::string& recorded, std::vector<StampedPose> (&read)()) {
  if (Recorded("robots/fetch.urdf").empty() || Recorded(recorded).empty()) {
    GTEST_SKIP() << "HGROS_DATA names no folder with robots/fetch.urdf and " << recorded << ".";
  }
  const std::vector<StampedPose> trajectory = read();
  const RobotDescription robot = RobotDescription::FromFile(Recorded("robots/fetch.urdf"));
  TransformTree tree({.buffer = std::chrono::minutes(1)});  // The TUM trajectory has gaps of 12 s.
  ASSERT_TRUE(robot.SetFixed(tree));
  ASSERT_EQ(robot.joints().size(), 10U);
  const FrameId map = tree.Frame("map");
  const FrameId root = tree.Frame(robot.root());
  const FrameId gripper = tree.Frame("gripper_link");
  std::size_t compared = 0;
  Time last{-1};
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const auto& [stamp, pose] = trajectory[i];
    ASSERT_TRUE(tree.Set(map, root, stamp, pose)) << i;
    std::vector<JointPosition> joints;
    for (const std::string& name : robot.joints()) {
      joints.push_back({name, 0.3 * std::sin(0.01 * static_cast<double>(i) + static_cast<double>(joints.size()))});
    }
    ASSERT_TRUE(robot.SetJoints(tree, stamp, joints));
    if (i > 0 && stamp > last) {
      const Time between{last.nanoseconds + (stamp - last).count() / 3};
      const double t = static_cast<double>((between - last).count()) / static_cast<double>((stamp - last).count());
      const RigidTransform& a = trajectory[i - 1].pose;
      const auto base = tree.Lookup(map, root, between);
      ASSERT_TRUE(base) << base.text();
      const RigidTransform expected{a.rotation.normalized().slerp(t, pose.rotation.normalized()),
                                    a.translation + t * (pose.translation - a.translation)};
      ASSERT_LT(Difference(base->T_target_source, expected), 1e-9) << i;
      const auto arm = tree.Lookup(root, gripper, between);
      ASSERT_TRUE(arm) << arm.text();
      const auto whole = tree.Lookup(map, gripper, between);
      ASSERT_TRUE(whole) << whole.text();
      ASSERT_LT(Difference(whole->T_target_source, expected * arm->T_target_source), 1e-9) << i;
      ++compared;
    }
    last = stamp;
  }
  EXPECT_GT(compared, trajectory.size() / 2);
  EXPECT_FALSE(trajectory.empty());
}

TEST(Fetch, DrivesAlongTheKittiTrajectory) { DriveFetch("trajectories/kitti_00_gt.txt", ReadKitti); }
TEST(Fetch, MovesAlongTheTumTrajectory) { DriveFetch("trajectories/tum_fr2_desk_gt.txt", ReadTum); }

}  // namespace
}  // namespace hgros
