// Plays the run to RViz: topics "scan", "path" and "tf".
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <cstring>

#include "playing.hpp"

namespace {

namespace slam_run = hgros::bench::slam_run;

geometry_msgs::TransformStamped TransformOf(const slam_run::Pose& pose, const char* parent, const char* child,
                                            ros::Time time) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = time;
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform.translation.x = pose.x;
  transform.transform.translation.y = pose.y;
  transform.transform.translation.z = pose.z;
  transform.transform.rotation.z = std::sin(pose.yaw / 2);
  transform.transform.rotation.w = std::cos(pose.yaw / 2);
  return transform;
}

sensor_msgs::PointCloud2 CloudOf(const std::vector<float>& scan, ros::Time time) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = time;
  cloud.header.frame_id = "lidar";
  for (const char* name : {"x", "y", "z", "intensity"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(sizeof(float) * cloud.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.point_step = 16;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(scan.size() / 4);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.is_dense = 1;
  cloud.data.resize(scan.size() * sizeof(float));
  std::memcpy(cloud.data.data(), scan.data(), cloud.data.size());
  return cloud;
}

}  // namespace

int main(int argc, char** argv) {
  const slam_run::Plan plan = slam_run::ReadPlan(argc, argv);
  ros::init(argc, argv, "play_ros1");
  ros::NodeHandle node;
  auto scans = node.advertise<sensor_msgs::PointCloud2>("scan", 5);
  auto paths = node.advertise<nav_msgs::Path>("path", 2);
  auto transforms = node.advertise<tf2_msgs::TFMessage>("tf", 100);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  for (int i = 0; i < 300 && scans.getNumSubscribers() == 0; ++i) ros::WallDuration(0.1).sleep();
  if (scans.getNumSubscribers() == 0) {
    std::fputs("No viewer connected within 30 s.\n", stderr);
    return 1;
  }
  nav_msgs::Path path;
  path.header.frame_id = "map";
  slam_run::Play(plan, [&](const slam_run::Pose& pose, const std::vector<float>& scan, std::size_t /*step*/) {
    const ros::Time now = ros::Time::now();
    tf2_msgs::TFMessage moved;
    moved.transforms = {TransformOf(pose, "map", "base", now), TransformOf(slam_run::kLidar, "base", "lidar", now)};
    transforms.publish(moved);
    scans.publish(CloudOf(scan, now));
    geometry_msgs::PoseStamped stamped;
    stamped.header.stamp = now;
    stamped.header.frame_id = "map";
    stamped.pose.position.x = pose.x;
    stamped.pose.position.y = pose.y;
    stamped.pose.position.z = pose.z;
    stamped.pose.orientation = moved.transforms[0].transform.rotation;
    path.header.stamp = now;
    path.poses.push_back(stamped);
    paths.publish(path);
  });
  ros::WallDuration(2).sleep();  // Time to send queued messages.
  ros::shutdown();
  return 0;
}
