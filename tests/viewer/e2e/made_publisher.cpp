// Publishes the made world as a robot that drives through it:
// viewer_made_publisher [HZ [POINTS [STEPS [NETWORK.yaml]]]]. With a network file it is the robot of the paper's second
// use case. That offers to a viewer on another machine what the file names: the clouds "lidar_visual_channel" and the
// path "re_optimized_poses", which is bent until a loop closure corrects it at step 30.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "hgros/clock/rate.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "viewer/e2e/made_world.hpp"

int main(int argc, char** argv) {
  using namespace hgros;
  namespace world = viewer::test::made_world;
  constexpr std::size_t kClosure = 30;
  const double hz = argc > 1 ? std::atof(argv[1]) : 10;
  const auto points = static_cast<std::size_t>(argc > 2 ? std::atol(argv[2]) : 20000);
  const auto steps = static_cast<std::size_t>(argc > 3 ? std::atol(argv[3]) : 1200);
  const bool of_paper = argc > 4;
  Session session(of_paper ? Config::Load(argv[4]) : Config::OfEnvironment());
  Transforms transforms(session);
  transforms.ToStaticTF("base", "lidar", RigidTransform({1, 0, 0, 0}, {0, 0, 1.7}));
  auto cloud = session.Advertise<Bulk<foxglove::PointCloud>>(of_paper ? "lidar_visual_channel" : "cloud");
  auto scan = session.Advertise<foxglove::LaserScan>("scan");
  auto trajectory = session.Advertise<foxglove::PosesInFrame>(of_paper ? "re_optimized_poses" : "trajectory");
  auto things = session.Advertise<foxglove::SceneUpdate>("things");
  if (!of_paper && !session.WaitForSubscribers("cloud", 1, std::chrono::seconds(20))) {
    std::fputs("Nobody listens.\n", stderr);
  }
  Rate rate(session.clock(), Duration(static_cast<std::int64_t>(1e9 / hz)));
  for (std::size_t i = 0; i < steps; ++i) {
    const Time now = WallNow();
    const std::size_t step = of_paper ? i % 200 : i;
    transforms.ToTF(now, "map", "base", world::PoseAt(step));
    transforms.Flush();
    cloud(world::CloudAt(step, points, now.nanoseconds));
    scan(std::make_unique<foxglove::LaserScan>(world::ScanAt(step, now.nanoseconds)));
    auto way = std::make_unique<foxglove::PosesInFrame>(world::TrajectoryUntil(step, now.nanoseconds));
    for (int pose = 0; of_paper && i < kClosure && pose < way->poses_size(); ++pose) {
      way->mutable_poses(pose)->mutable_position()->set_z(0.02 * pose * pose);
    }
    trajectory(std::move(way));
    things(std::make_unique<foxglove::SceneUpdate>(world::ThingsAt(step, now.nanoseconds)));
    (void)rate.Sleep();
  }
  return 0;
}
