#include "viewer/e2e/made_world.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <string>

#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer::test::made_world {
namespace {

constexpr double kStepMeters = 0.5;

/// The nearest wall along a ray in the plane: houses on both sides of a street that is 12 m wide and follows the
/// robot's path, with a gap every 20 m.
double Range(const RigidTransform& pose, double angle) {
  const Eigen::Vector3d direction = pose.rotation * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  for (double range = 0.5; range < 60; range += 0.25) {
    const Eigen::Vector3d at = pose.translation + range * direction;
    const double gap = std::fmod(std::abs(at.x()) + 3, 20);
    const double middle = 22.5 * (1 - std::cos(at.x() / 25));
    if (std::abs(at.y() - middle) > (gap < 5 ? 16 : 6)) return range;
  }
  return 60;
}

foxglove::SceneEntity& AddStamped(foxglove::SceneUpdate& update, const std::string& id, const std::string& frame,
                                  std::int64_t stamp_ns) {
  foxglove::SceneEntity& entity = AddEntity(update, id, frame);
  SetStamp(*entity.mutable_timestamp(), stamp_ns);
  return entity;
}

template <class Solid>
void SetPlacedSolid(Solid& solid, const RigidTransform& pose, const Eigen::Vector3d& size,
                    const Eigen::Vector4d& rgba) {
  SetSolid(solid, Eigen::Vector3d::Zero(), size, rgba);
  SetPose(*solid.mutable_pose(), pose);
}

}  // namespace

RigidTransform PoseAt(std::size_t step) {
  const double x = kStepMeters * static_cast<double>(step);
  const double slope = 0.9 * std::sin(x / 25);
  return {RigidTransform::Rotation(Eigen::AngleAxisd(std::atan(slope), Eigen::Vector3d::UnitZ())),
          Eigen::Vector3d(x, 22.5 * (1 - std::cos(x / 25)), 0)};
}

std::unique_ptr<Bulk<foxglove::PointCloud>> CloudAt(std::size_t step, std::size_t points, std::int64_t stamp_ns) {
  std::mt19937 random(static_cast<unsigned>(step));
  std::uniform_real_distribution<double> unit(0, 1);
  const RigidTransform pose = PoseAt(step);
  auto cloud = std::make_unique<Bulk<foxglove::PointCloud>>(points * 16);
  foxglove::PointCloud& head = cloud->head();
  head.set_frame_id("lidar");
  SetStamp(*head.mutable_timestamp(), stamp_ns);
  SetFloatFields(head);
  constexpr std::size_t kRays = 720;
  std::array<double, kRays> ranges;
  for (std::size_t i = 0; i < kRays; ++i)
    ranges[i] = Range(pose, 2 * std::numbers::pi * static_cast<double>(i) / kRays);
  for (std::size_t i = 0; i < points; ++i) {
    const double turn = unit(random);
    const double angle = 2 * std::numbers::pi * turn;
    const double to_wall = ranges[static_cast<std::size_t>(turn * kRays) % kRays];
    const bool ground = unit(random) < 0.4;
    const double range = ground ? to_wall * std::sqrt(unit(random)) : to_wall + 0.05 * unit(random);
    const double height = ground ? -1.7 : -1.7 + 7 * unit(random);
    const std::array<float, 4> point = {static_cast<float>(range * std::cos(angle)),
                                        static_cast<float>(range * std::sin(angle)), static_cast<float>(height),
                                        static_cast<float>(ground ? 0.2 : 0.4 + 0.6 * unit(random))};
    std::memcpy(cloud->writable().data() + 16 * i, point.data(), sizeof point);
  }
  return cloud;
}

foxglove::LaserScan ScanAt(std::size_t step, std::int64_t stamp_ns) {
  const RigidTransform pose = PoseAt(step);
  foxglove::LaserScan scan;
  scan.set_frame_id("lidar");
  SetStamp(*scan.mutable_timestamp(), stamp_ns);
  constexpr int kRays = 541;
  scan.set_start_angle(-0.75 * std::numbers::pi);
  scan.set_end_angle(0.75 * std::numbers::pi);
  for (int i = 0; i < kRays; ++i) scan.add_ranges(Range(pose, (1.5 * i / (kRays - 1) - 0.75) * std::numbers::pi));
  return scan;
}

foxglove::PosesInFrame TrajectoryUntil(std::size_t step, std::int64_t stamp_ns) {
  foxglove::PosesInFrame poses;
  poses.set_frame_id("map");
  SetStamp(*poses.mutable_timestamp(), stamp_ns);
  for (std::size_t i = 0; i <= step; ++i) SetPose(*poses.add_poses(), PoseAt(i));
  return poses;
}

foxglove::SceneUpdate ThingsAt(std::size_t step, std::int64_t stamp_ns) {
  foxglove::SceneUpdate update;
  foxglove::SceneEntity& robot = AddStamped(update, "robot", "base", stamp_ns);
  robot.set_frame_locked(true);
  robot.mutable_lifetime()->set_seconds(1);
  SetPlacedSolid(*robot.add_cubes(), RigidTransform({1, 0, 0, 0}, {0, 0, 0.7}), {3, 1.6, 1.4}, {0.25, 0.5, 0.95, 0.8});
  foxglove::ArrowPrimitive& ahead = *robot.add_arrows();
  SetPose(*ahead.mutable_pose(), RigidTransform({1, 0, 0, 0}, {2, 0, 0.7}));
  ahead.set_shaft_length(2);
  ahead.set_shaft_diameter(0.3);
  ahead.set_head_length(1);
  ahead.set_head_diameter(0.8);
  SetColor(*ahead.mutable_color(), 0.95, 0.75, 0.1);
  foxglove::TextPrimitive& name = *robot.add_texts();
  SetPose(*name.mutable_pose(), RigidTransform({1, 0, 0, 0}, {0, 0, 2.4}));
  name.set_text("rover");
  name.set_font_size(1.2);
  SetColor(*name.mutable_color(), 1, 0.9, 0.5);
  constexpr std::size_t kStepsBetween = 100;
  if (step % kStepsBetween == 0) {
    foxglove::SceneEntity& post = AddStamped(update, "post " + std::to_string(step / kStepsBetween), "map", stamp_ns);
    const RigidTransform foot = PoseAt(step);
    SetPlacedSolid(*post.add_spheres(), foot * RigidTransform({1, 0, 0, 0}, {0, 3, 2}), {0.8, 0.8, 0.8},
                   {0.9, 0.25, 0.3, 1});
    auto& pole = *post.add_cylinders();
    SetPlacedSolid(pole, foot * RigidTransform({1, 0, 0, 0}, {0, 3, 0.8}), {0.2, 0.2, 1.6}, {0.7, 0.7, 0.72, 1});
    pole.set_bottom_scale(1);
    pole.set_top_scale(1);
  }
  return update;
}

}  // namespace hgros::viewer::test::made_world
