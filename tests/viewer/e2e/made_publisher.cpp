// Publishes the made world as a robot that drives through it: viewer_made_publisher [HZ [POINTS [STEPS]]].
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
  const double hz = argc > 1 ? std::atof(argv[1]) : 10;
  const auto points = static_cast<std::size_t>(argc > 2 ? std::atol(argv[2]) : 20000);
  const auto steps = static_cast<std::size_t>(argc > 3 ? std::atol(argv[3]) : 1200);
  Session session;
  Transforms transforms(session);
  transforms.ToStaticTF("base", "lidar", RigidTransform({1, 0, 0, 0}, {0, 0, 1.7}));
  auto cloud = session.Advertise<Bulk<foxglove::PointCloud>>("cloud");
  auto scan = session.Advertise<foxglove::LaserScan>("scan");
  auto trajectory = session.Advertise<foxglove::PosesInFrame>("trajectory");
  auto things = session.Advertise<foxglove::SceneUpdate>("things");
  if (!session.WaitForSubscribers("cloud", 1, std::chrono::seconds(20))) std::fputs("Nobody listens.\n", stderr);
  Rate rate(session.clock(), Duration(static_cast<std::int64_t>(1e9 / hz)));
  for (std::size_t step = 0; step < steps; ++step) {
    const Time now = WallNow();
    transforms.ToTF(now, "map", "base", world::PoseAt(step));
    transforms.Flush();
    cloud(world::CloudAt(step, points, now.nanoseconds));
    scan(std::make_unique<foxglove::LaserScan>(world::ScanAt(step, now.nanoseconds)));
    trajectory(std::make_unique<foxglove::PosesInFrame>(world::TrajectoryUntil(step, now.nanoseconds)));
    things(std::make_unique<foxglove::SceneUpdate>(world::ThingsAt(step, now.nanoseconds)));
    (void)rate.Sleep();
  }
  return 0;
}
