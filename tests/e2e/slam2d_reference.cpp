// The SLAM front end in one thread and without the library, for comparison: the processes must get the same result,
// bit for bit. slam2d_reference SCANS [LOG] prints the hashes of map and trajectory.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <carmen_log.hpp>
#include <pipeline.hpp>
#include <simulated_building.hpp>

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  try {
    slam2d::Pipeline pipeline;
    slam2d::SimulationOptions simulation;
    simulation.scans = std::strtoull(argv[1], nullptr, 10);
    if (argc > 2) {
      slam2d::CarmenLogReader log(argv[2]);
      for (std::size_t i = 0; i < simulation.scans; ++i) {
        const auto scan = log.Next();
        if (!scan) break;
        pipeline.Add(*scan);
      }
    } else {
      slam2d::SimulatedBuilding building(simulation);
      for (slam2d::LaserScan2 scan; building.Next(scan);) pipeline.Add(scan);
    }
    std::printf("%016" PRIx64 " %016" PRIx64 "\n", slam2d::HashMap(pipeline.map()),
                slam2d::HashTrajectory(pipeline.trajectory()));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
