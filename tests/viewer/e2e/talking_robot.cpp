// A robot with data for each panel: viewer_talking_robot [STEPS [HZ]]. Several sessions publish and subscribe;
// "broken_..." carry bytes that do not match their type.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/Grid.pb.h"
#include "foxglove/LaserScan.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "foxglove/PosesInFrame.pb.h"
#include "foxglove/RawImage.pb.h"
#include "foxglove/VoxelGrid.pb.h"
#include "hgros/clock/rate.hpp"
#include "hgros/session/session.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace {

using namespace hgros;
using viewer::test::SetStamp;

foxglove::Log LineAt(std::size_t step, Time now) {
  foxglove::Log log;
  SetStamp(*log.mutable_timestamp(), now.nanoseconds);
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
  SetStamp(*pose.mutable_timestamp(), now.nanoseconds);
  viewer::test::SetPose(
      *pose.mutable_pose(),
      RigidTransform({1, 0, 0, 0}, {4 * std::cos(0.5 * t), 4 * std::sin(0.5 * t), 0.2 * std::sin(6 * t)}));
  return pose;
}

/// For bytes that do not match their type.
template <class T>
RawPublisher BreakerOf(Session& session, const std::string& channel) {
  return session.AdvertiseRaw(channel, SchemaOf(TypeOf<T>()));
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
  std::mt19937 random(5);
  const std::vector<RawPublisher> breakers = {BreakerOf<foxglove::PointCloud>(driver, "broken_cloud"),
                                              BreakerOf<foxglove::LaserScan>(driver, "broken_scan"),
                                              BreakerOf<foxglove::PosesInFrame>(driver, "broken_way"),
                                              BreakerOf<foxglove::Log>(planner, "broken_log"),
                                              BreakerOf<foxglove::Grid>(driver, "broken_grid"),
                                              BreakerOf<foxglove::VoxelGrid>(driver, "broken_voxels"),
                                              BreakerOf<foxglove::SceneUpdate>(driver, "broken_scene"),
                                              BreakerOf<foxglove::RawImage>(driver, "broken_image"),
                                              BreakerOf<foxglove::CompressedImage>(driver, "broken_photo"),
                                              BreakerOf<foxglove::PoseInFrame>(driver, "broken_pose")};
  Rate rate(driver.clock(), Duration(static_cast<std::int64_t>(1e9 / hz)));
  for (std::size_t step = 0; step < steps; ++step) {
    const Time now = WallNow();
    log(LineAt(step, now));
    odometry(PoseAt(step, hz, now));
    if (step % 10 == 0) goal(PoseAt(step + 40, hz, now));
    for (const RawPublisher& publish_broken : breakers) {
      const auto bytes = std::make_shared<std::string>(random() % 200, '\0');
      for (char& byte : *bytes) byte = static_cast<char>(random() & 255U);
      publish_broken({AsBytes(*bytes), bytes});
    }
    (void)rate.Sleep();
  }
  return 0;
}
