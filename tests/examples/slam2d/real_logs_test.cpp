// The logs of the Intel Research Lab, Seattle, and of the ACES building, Austin (Radish, the robotics data set
// repository), if the environment variable HGROS_DATA names a folder that contains lidar2d/. With a sanitizer they take
// minutes, and the tests of the pipeline run the same code.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "carmen_log.hpp"
#include "pipeline.hpp"
#include "relations_error.hpp"

namespace slam2d {
namespace {

// Empty if the file is not there.
std::filesystem::path DataFile(const char* name) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return {};
#endif
  const char* folder = std::getenv("HGROS_DATA");
  if (folder == nullptr) return {};
  const std::filesystem::path path = std::filesystem::path(folder) / "lidar2d" / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path{};
}

void RunLog(const std::filesystem::path& path, Pipeline& pipeline) {
  CarmenLogReader reader(path);
  while (const auto scan = reader.Next()) pipeline.Add(*scan);
  EXPECT_EQ(reader.malformed_lines(), 0U) << reader.first_malformed();
}

// Between the 1st and the 99th percentile, so that glances through a window do not count.
double Extent_m(std::vector<double>& coordinates) {
  std::ranges::sort(coordinates);
  return coordinates[coordinates.size() * 99 / 100] - coordinates[coordinates.size() / 100];
}

TEST(RealLogs, IntelMapIsAsLargeAsTheBuilding) {
  const auto path = DataFile("intel.clf.gz");
  if (path.empty()) GTEST_SKIP() << "HGROS_DATA names no folder with lidar2d/intel.clf.gz, or there is a sanitizer.";
  Pipeline pipeline;
  RunLog(path, pipeline);
  EXPECT_EQ(pipeline.trajectory().size(), 13631U);
  std::vector<double> x;
  std::vector<double> y;
  const double cell_size_m = pipeline.map().options().cell_size_m;
  for (const auto& [index, tile] : pipeline.map().tiles()) {
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] <= 0) continue;
      x.push_back((index.x * kTileEdgeCells + static_cast<int>(cell % kTileEdgeCells)) * cell_size_m);
      y.push_back((index.y * kTileEdgeCells + static_cast<int>(cell / kTileEdgeCells)) * cell_size_m);
    }
  }
  EXPECT_NEAR(Extent_m(x), 29.0, 1.5);
  EXPECT_NEAR(Extent_m(y), 29.0, 1.5);
  // A smeared map has far more wall than the building.
  EXPECT_LT(x.size(), 20000U);
}

TEST(RealLogs, AcesAgreesWithTheVerifiedRelations) {
  const auto path = DataFile("aces.clf.gz");
  const auto relations_path = DataFile("aces.relations");
  if (path.empty() || relations_path.empty())
    GTEST_SKIP() << "No lidar2d/aces.* in HGROS_DATA, or there is a sanitizer.";
  Pipeline pipeline;
  RunLog(path, pipeline);
  const RelationsError error = CompareWithRelations(pipeline.trajectory(), ReadRelations(relations_path));
  EXPECT_EQ(error.relations, 1279U);
  EXPECT_LT(error.mean_translation_m, 0.1);
  EXPECT_LT(error.mean_rotation_rad, 0.02);
}

}  // namespace
}  // namespace slam2d
