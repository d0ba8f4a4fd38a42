// A robot with data for each panel: viewer_talking_robot [STEPS [HZ]]. Several sessions publish and subscribe;
// "broken_..." carry bytes that do not match their type.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/Grid.pb.h"
#include "foxglove/LaserScan.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "foxglove/RawImage.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "foxglove/VoxelGrid.pb.h"
#include "hgros/clock/rate.hpp"
#include "hgros/codec/custom_codec.hpp"
#include "hgros/session/session.hpp"

namespace {

/// Bytes that do not match the type that they are published with.
template <class T>
struct Broken {
  std::string bytes;
};

}  // namespace

template <class T>
struct hgros::CustomCodec<Broken<T>> {
  using Schema = T;
  static bool Serialize(const Broken<T>& broken, std::string& bytes) {
    bytes = broken.bytes;
    return true;
  }
  static bool Parse(std::string_view bytes, Broken<T>& broken) {
    broken.bytes = bytes;
    return true;
  }
};

namespace {

using namespace hgros;

void SetStamp(google::protobuf::Timestamp& stamp, Time time) {
  stamp.set_seconds(time.nanoseconds / 1'000'000'000);
  stamp.set_nanos(static_cast<std::int32_t>(time.nanoseconds % 1'000'000'000));
}

foxglove::Log LineAt(std::size_t step, Time now) {
  foxglove::Log log;
  SetStamp(*log.mutable_timestamp(), now);
  log.set_name(step % 3 == 0 ? "planner" : "driver");
  log.set_file("src/drive.cpp");
  log.set_line(static_cast<std::uint32_t>(10 + step % 90));
  if (step % 20 == 19) {
    log.set_level(foxglove::Log::ERROR);
    log.set_message("no path to the goal within 5 s; trying again from step " + std::to_string(step));
  } else if (step % 7 == 6) {
    log.set_level(foxglove::Log::WARNING);
    log.set_message("wheel slips: " + std::to_string(step % 13) + " % of the way was lost");
  } else {
    log.set_level(step % 2 == 0 ? foxglove::Log::INFO : foxglove::Log::DEBUG);
    log.set_message("step " + std::to_string(step));
  }
  return log;
}

foxglove::PoseInFrame PoseAt(std::size_t step, double hz, Time now) {
  const double t = static_cast<double>(step) / hz;
  foxglove::PoseInFrame pose;
  pose.set_frame_id("map");
  SetStamp(*pose.mutable_timestamp(), now);
  pose.mutable_pose()->mutable_position()->set_x(4 * std::cos(0.5 * t));
  pose.mutable_pose()->mutable_position()->set_y(4 * std::sin(0.5 * t));
  pose.mutable_pose()->mutable_position()->set_z(0.2 * std::sin(6 * t));
  pose.mutable_pose()->mutable_orientation()->set_w(1);
  return pose;
}

template <class T>
std::unique_ptr<Broken<T>> BrokenBytes(std::mt19937& random) {
  auto broken = std::make_unique<Broken<T>>();
  broken->bytes.resize(random() % 200);
  for (char& byte : broken->bytes) byte = static_cast<char>(random() & 255U);
  return broken;
}

}  // namespace

int main(int argc, char** argv) {
  const auto steps = static_cast<std::size_t>(argc > 1 ? std::atol(argv[1]) : 1200);
  const double hz = argc > 2 ? std::atof(argv[2]) : 20;
  Session driver(Config(), {.name = "driver"});
  Session planner(Config(), {.name = "planner"});
  std::vector<Subscription> subscriptions;
  for (const char* channel : {"odometry", "goal"}) {
    subscriptions.push_back(
        planner.FromAny<foxglove::PoseInFrame>(channel, Invoke::kSerial, [](const foxglove::PoseInFrame&) {}));
  }
  subscriptions.push_back(
      driver.FromAny<foxglove::PoseInFrame>("goal", Invoke::kSerial, [](const foxglove::PoseInFrame&) {}));
  auto log = driver.Advertise<foxglove::Log>("log");
  auto odometry = driver.Advertise<foxglove::PoseInFrame>("odometry");
  auto goal = planner.Advertise<foxglove::PoseInFrame>("goal");
  auto broken_cloud = driver.Advertise<Broken<foxglove::PointCloud>>("broken_cloud");
  auto broken_scan = driver.Advertise<Broken<foxglove::LaserScan>>("broken_scan");
  auto broken_way = driver.Advertise<Broken<foxglove::PosesInFrame>>("broken_way");
  auto broken_log = planner.Advertise<Broken<foxglove::Log>>("broken_log");
  auto broken_grid = driver.Advertise<Broken<foxglove::Grid>>("broken_grid");
  auto broken_voxels = driver.Advertise<Broken<foxglove::VoxelGrid>>("broken_voxels");
  auto broken_scene = driver.Advertise<Broken<foxglove::SceneUpdate>>("broken_scene");
  auto broken_image = driver.Advertise<Broken<foxglove::RawImage>>("broken_image");
  auto broken_photo = driver.Advertise<Broken<foxglove::CompressedImage>>("broken_photo");
  auto broken_pose = driver.Advertise<Broken<foxglove::PoseInFrame>>("broken_pose");
  std::mt19937 random(5);
  Rate rate(driver.clock(), Duration(static_cast<std::int64_t>(1e9 / hz)));
  for (std::size_t step = 0; step < steps; ++step) {
    const Time now = WallNow();
    log(LineAt(step, now));
    odometry(PoseAt(step, hz, now));
    if (step % 10 == 0) goal(PoseAt(step + 40, hz, now));
    broken_cloud(BrokenBytes<foxglove::PointCloud>(random));
    broken_scan(BrokenBytes<foxglove::LaserScan>(random));
    broken_way(BrokenBytes<foxglove::PosesInFrame>(random));
    broken_log(BrokenBytes<foxglove::Log>(random));
    broken_grid(BrokenBytes<foxglove::Grid>(random));
    broken_voxels(BrokenBytes<foxglove::VoxelGrid>(random));
    broken_scene(BrokenBytes<foxglove::SceneUpdate>(random));
    broken_image(BrokenBytes<foxglove::RawImage>(random));
    broken_photo(BrokenBytes<foxglove::CompressedImage>(random));
    broken_pose(BrokenBytes<foxglove::PoseInFrame>(random));
    (void)rate.Sleep();
  }
  return 0;
}
