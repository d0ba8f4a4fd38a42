// Publishes recorded data as the robot did: viewer_recorded_publisher kitti|intel|aces|willow|fr079|fetch|tum FOLDER
// [HZ], FOLDER contains lidar3d/, lidar2d/, maps/, robots/ and images/.
#include <zlib.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/LaserScan.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "hgros/clock/rate.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/robot_description.hpp"
#include "hgros/tf/transforms.hpp"
#include "viewer/e2e/message_parts.hpp"
#include "viewer/e2e/recorded_maps.hpp"

namespace {

using namespace hgros;
using viewer::test::ReadMap;
using viewer::test::ReadOctree;
using viewer::test::SetFloatFields;
using viewer::test::SetPose;
using viewer::test::SetStamp;

constexpr int kRepeats = 60;

std::string Unpacked(const std::filesystem::path& file) {
  std::string text;
  gzFile opened = gzopen(file.c_str(), "rb");
  if (opened == nullptr) return text;
  char part[65536];
  for (int got = 0; (got = gzread(opened, part, sizeof part)) > 0;) text.append(part, static_cast<std::size_t>(got));
  gzclose(opened);
  return text;
}

std::unique_ptr<Bulk<foxglove::PointCloud>> KittiCloud(const std::string& bytes, Time stamp) {
  auto cloud = std::make_unique<Bulk<foxglove::PointCloud>>(bytes.size());
  foxglove::PointCloud& head = cloud->head();
  head.set_frame_id("velodyne");
  SetStamp(*head.mutable_timestamp(), stamp.nanoseconds);
  SetFloatFields(head);
  std::memcpy(cloud->writable().data(), bytes.data(), bytes.size());
  return cloud;
}

int Kitti(Session& session, const std::filesystem::path& folder, Duration period) {
  Transforms transforms(session);
  auto clouds = session.Advertise<Bulk<foxglove::PointCloud>>("cloud");
  auto ways = session.Advertise<foxglove::PosesInFrame>("trajectory");
  (void)session.WaitForSubscribers("cloud", 1, std::chrono::seconds(20));
  std::ifstream poses(folder / "poses_derived.txt");
  foxglove::PosesInFrame way;
  way.set_frame_id("map");
  Rate rate(session.clock(), period);
  std::string line;
  for (int i = 0; std::getline(poses, line); ++i) {
    std::istringstream numbers(line);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) numbers >> T.matrix()(row, column);
    }
    char name[32];
    std::snprintf(name, sizeof name, "%06d.bin.gz", i);
    const Time now = WallNow();
    transforms.ToTF(now, "map", "velodyne", T);
    transforms.Flush();
    clouds(KittiCloud(Unpacked(folder / "velodyne" / name), now));
    SetPose(*way.add_poses(), RigidTransform(T));
    ways(way);
    (void)rate.Sleep();
  }
  return 0;
}

int Carmen(Session& session, const std::filesystem::path& file, Duration period) {
  Transforms transforms(session);
  auto scans = session.Advertise<foxglove::LaserScan>("scan");
  auto ways = session.Advertise<foxglove::PosesInFrame>("trajectory");
  (void)session.WaitForSubscribers("scan", 1, std::chrono::seconds(20));
  std::istringstream log(Unpacked(file));
  foxglove::PosesInFrame way;
  way.set_frame_id("odom");
  Rate rate(session.clock(), period);
  std::string line;
  while (std::getline(log, line)) {
    std::istringstream words(line);
    std::string kind;
    int count = 0;
    if (!(words >> kind >> count) || kind != "FLASER") continue;
    const Time now = WallNow();
    foxglove::LaserScan scan;
    scan.set_frame_id("laser");
    SetStamp(*scan.mutable_timestamp(), now.nanoseconds);
    scan.set_start_angle(-std::numbers::pi / 2);
    scan.set_end_angle(std::numbers::pi / 2 - std::numbers::pi / count);
    for (int i = 0; i < count; ++i) {
      double range = 0;
      words >> range;
      scan.add_ranges(range < 30 ? range : INFINITY);
    }
    double x = 0;
    double y = 0;
    double heading = 0;
    words >> x >> y >> heading;
    const RigidTransform pose(RigidTransform::Rotation(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ())),
                              {x, y, 0});
    transforms.ToTF(now, "odom", "laser", pose);
    transforms.Flush();
    scans(scan);
    SetPose(*way.add_poses(), pose);
    ways(way);
    (void)rate.Sleep();
  }
  return 0;
}

/// Sends the same message repeatedly until the program is ended.
template <class T>
int Repeat(Session& session, const std::string& channel, std::unique_ptr<T> message, Duration period) {
  auto publish = session.Advertise<T>(channel);
  const std::shared_ptr<const T> shared = std::move(message);
  Rate rate(session.clock(), period);
  for (int i = 0; i < kRepeats; ++i) {
    publish(shared);
    (void)rate.Sleep();
  }
  return 0;
}

int Images(Session& session, const std::filesystem::path& folder, Duration period) {
  auto colors = session.Advertise<foxglove::CompressedImage>("color");
  auto depths = session.Advertise<foxglove::CompressedImage>("depth");
  Rate rate(session.clock(), period);
  for (int i = 0; i < kRepeats; ++i) {
    const std::string number(1, static_cast<char>('1' + i % 2));
    for (const auto& [publish, name] : {std::pair(&colors, number + ".png"), {&depths, number + "_depth.png"}}) {
      foxglove::CompressedImage image;
      image.set_frame_id("camera");
      image.set_format("png");
      SetStamp(*image.mutable_timestamp(), WallNow().nanoseconds);
      std::ifstream file(folder / name, std::ios::binary);
      image.mutable_data()->assign(std::istreambuf_iterator<char>(file), {});
      (*publish)(image);
    }
    (void)rate.Sleep();
  }
  return 0;
}

/// Its joints swing around their middle.
int Robot(Session& session, const std::filesystem::path& urdf, Duration period) {
  const RobotDescription robot = RobotDescription::FromFile(urdf);
  Transforms transforms(session);
  (void)transforms.ToStaticTF(robot.FixedEdges());
  Rate rate(session.clock(), period);
  for (int i = 0; i < 20 * kRepeats; ++i) {
    std::vector<JointPosition> positions;
    for (const std::string& joint : robot.joints()) {
      positions.push_back({joint, joint.starts_with("base") ? 0 : 0.3 * std::sin(0.1 * i)});
    }
    (void)transforms.ToTF(robot.EdgesAt(WallNow(), positions));
    transforms.Flush();
    (void)rate.Sleep();
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: viewer_recorded_publisher kitti|intel|aces|willow|fr079|fetch|tum FOLDER [HZ]\n", stderr);
    return 2;
  }
  const std::string what = argv[1];
  const std::filesystem::path folder = argv[2];
  const Duration period(static_cast<std::int64_t>(1e9 / (argc > 3 ? std::atof(argv[3]) : 10)));
  Session session;
  if (what == "willow") {
    return Repeat(session, "map", ReadMap(folder / "maps" / "willow-2010-02-18-0.10.pgm", 0.1), period);
  }
  if (what == "fr079") {
    return Repeat(session, "voxels", ReadOctree(folder / "maps" / "freiburg_079_corridor.bt"), period);
  }
  if (what == "fetch") return Robot(session, folder / "robots" / "fetch.urdf", period);
  if (what == "tum") return Images(session, folder / "images" / "tum_rgbd_pair", period);
  if (what == "kitti") return Kitti(session, folder / "lidar3d" / "kitti_drive0005", period);
  return Carmen(session, folder / "lidar2d" / (what + ".clf.gz"), period);
}
