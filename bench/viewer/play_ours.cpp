// Plays the run to hgros-viewer: channels "scan" and "path", and transforms.
#include <chrono>
#include <cmath>
#include <memory>

#include <foxglove/PointCloud.pb.h>
#include <foxglove/PosesInFrame.pb.h>

#include "hgros/hgros.hpp"
#include "hgros/tf/transforms.hpp"
#include "playing.hpp"
#include "scan_cloud.hpp"

namespace {

using namespace hgros;
namespace slam_run = hgros::bench::slam_run;

RigidTransform TransformOf(const slam_run::Pose& pose) {
  return {{std::cos(pose.yaw / 2), 0, 0, std::sin(pose.yaw / 2)}, {pose.x, pose.y, pose.z}};
}

void SetStamp(google::protobuf::Timestamp& stamp, Time time) {
  stamp.set_seconds(time.nanoseconds / 1'000'000'000);
  stamp.set_nanos(static_cast<std::int32_t>(time.nanoseconds % 1'000'000'000));
}

std::unique_ptr<Bulk<foxglove::PointCloud>> CloudOf(Session& session, const std::vector<float>& scan, Time time) {
  auto cloud = session.Loan<Bulk<foxglove::PointCloud>>("scan", scan.size() * sizeof(float));
  slam_run::WriteScan(scan, "lidar", *cloud);
  SetStamp(*cloud->head().mutable_timestamp(), time);
  return cloud;
}

void AddPose(foxglove::PosesInFrame& path, const slam_run::Pose& pose) {
  auto* const added = path.add_poses();
  added->mutable_position()->set_x(pose.x);
  added->mutable_position()->set_y(pose.y);
  added->mutable_position()->set_z(pose.z);
  added->mutable_orientation()->set_z(std::sin(pose.yaw / 2));
  added->mutable_orientation()->set_w(std::cos(pose.yaw / 2));
}

}  // namespace

int main(int argc, char** argv) {
  const slam_run::Plan plan = slam_run::ReadPlan(argc, argv);
  Session session;
  Transforms transforms(session);
  auto scans = session.Advertise<Bulk<foxglove::PointCloud>>("scan");
  auto paths = session.Advertise<foxglove::PosesInFrame>("path");
  transforms.ToStaticTF("base", "lidar", TransformOf(slam_run::kLidar));
  if (!session.WaitForSubscribers("scan", 1, std::chrono::seconds(30))) {
    std::fputs("No viewer connected within 30 s.\n", stderr);
    return 1;
  }
  foxglove::PosesInFrame path;
  path.set_frame_id("map");
  slam_run::Play(plan, [&](const slam_run::Pose& pose, const std::vector<float>& scan, std::size_t /*step*/) {
    const Time now = WallNow();
    transforms.ToTF(now, "map", "base", TransformOf(pose));
    transforms.Flush();
    scans(CloudOf(session, scan, now));
    SetStamp(*path.mutable_timestamp(), now);
    AddPose(path, pose);
    paths(std::make_unique<foxglove::PosesInFrame>(path));
  });
  return 0;
}
