// The robot of the paper's second use case: viewer_paper_robot NETWORK.yaml. Publishes what its network file offers to
// a viewer on another machine: the clouds "lidar_visual_channel" and the path "re_optimized_poses". The path is bent
// until a loop closure corrects it at step 30. Runs until it is killed.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "hgros/base/error.hpp"
#include "hgros/clock/rate.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "viewer/e2e/made_world.hpp"

namespace {

using namespace hgros;
namespace world = viewer::test::made_world;

constexpr std::size_t kClosure = 30;
constexpr std::size_t kPoints = 3000;

int Run(const std::filesystem::path& network) {
  Session session(Config::Load(network));
  Transforms transforms(session);
  transforms.ToStaticTF("base", "lidar", RigidTransform({1, 0, 0, 0}, {0, 0, 1.7}));
  auto clouds = session.Advertise<Bulk<foxglove::PointCloud>>("lidar_visual_channel");
  auto ways = session.Advertise<foxglove::PosesInFrame>("re_optimized_poses");
  Rate rate(session.clock(), Duration(std::int64_t{50'000'000}));
  for (std::size_t step = 0;; ++step) {
    const Time now = WallNow();
    transforms.ToTF(now, "map", "base", world::PoseAt(step % 200));
    transforms.Flush();
    clouds(world::CloudAt(step % 200, kPoints, now.nanoseconds));
    auto way = std::make_unique<foxglove::PosesInFrame>(world::TrajectoryUntil(step % 200, now.nanoseconds));
    for (int i = 0; step < kClosure && i < way->poses_size(); ++i) {
      way->mutable_poses(i)->mutable_position()->set_z(0.02 * i * i);
    }
    ways(std::move(way));
    (void)rate.Sleep();
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: viewer_paper_robot NETWORK.yaml\n", stderr);
    return 2;
  }
  try {
    return Run(argv[1]);
  } catch (const hgros::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
