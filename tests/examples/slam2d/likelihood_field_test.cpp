#include "likelihood_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulated_building.hpp"

namespace slam2d {
namespace {

constexpr double kSigma_m = 0.08;

int OracleValue(const OccupancyMap& map, int x, int y) {
  const double cell = map.options().cell_size_m;
  const int radius = static_cast<int>(std::ceil(3.0 * kSigma_m / cell));
  long best = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      if (map.At(x + dx, y + dy) <= 0) continue;
      const double d = std::hypot(dx, dy) * cell / kSigma_m;
      best = std::max(best, std::lround(255.0 * std::exp(-0.5 * d * d)));
    }
  }
  return static_cast<int>(best);
}

TEST(LikelihoodField, UpdatedByDeltasEqualsAFieldOfTheWholeMap) {
  SeededNoise noise(5);
  OccupancyMap map;
  LikelihoodField field(map.options().cell_size_m, kSigma_m);
  LaserScan2 scan;
  scan.angle_step_rad = std::numbers::pi / 20;
  scan.max_range_m = 50.0;
  for (std::uint64_t k = 0; k < 30; ++k) {
    scan.sequence = k;
    scan.ranges_m.clear();
    for (int i = 0; i < 40; ++i) scan.ranges_m.push_back(static_cast<float>(0.2 + 1.5 * noise.Uniform()));
    const Pose2 pose{1.0 + noise.Uniform(), -1.0 + noise.Uniform(), 6.0 * noise.Uniform()};
    field.Apply(map.Integrate(scan, pose));
  }
  const LikelihoodField::Level& fine = field.level(0);
  for (int y = -70; y < 60; ++y) {
    for (int x = -40; x < 90; ++x) {
      ASSERT_EQ(fine.values[fine.Index(x, y)], OracleValue(map, x, y)) << x << ", " << y;
    }
  }
}

TEST(LikelihoodField, CoarseLevelsAreTheMaximaOfTheirCells) {
  OccupancyMap map;
  LikelihoodField field(map.options().cell_size_m, kSigma_m);
  SimulatedBuilding building({.scans = 40});
  LaserScan2 scan;
  while (building.Next(scan)) field.Apply(map.Integrate(scan, building.true_pose()));
  const LikelihoodField::Level& fine = field.level(0);
  for (std::size_t l = 1; l < LikelihoodField::kLevels; ++l) {
    const LikelihoodField::Level& coarse = field.level(l);
    const int stride = LikelihoodField::kStride[l];
    for (int y = coarse.origin_y; y + 2 < coarse.origin_y + coarse.height; y += 3) {
      for (int x = coarse.origin_x; x + 2 < coarse.origin_x + coarse.width; x += 3) {
        std::uint8_t best = 0;
        for (int row = 0; row < 2 * stride; ++row) {
          const auto* cells = &fine.values[fine.Index(x * stride, y * stride + row)];
          best = std::max(best, *std::max_element(cells, cells + 2 * stride));
        }
        ASSERT_EQ(coarse.values[coarse.Index(x, y)], best) << "level " << l << " at " << x << ", " << y;
      }
    }
  }
}

TEST(LikelihoodField, ReturnsTheDerivativeOfTheInterpolatedValue) {
  OccupancyMap map;
  LikelihoodField field(map.options().cell_size_m, kSigma_m);
  LaserScan2 scan;
  scan.max_range_m = 50.0;
  scan.ranges_m = {1.0F};
  field.Apply(map.Integrate(scan, {}));
  SeededNoise noise(3);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const Point2 p{17.0 + 6.0 * noise.Uniform(), -3.0 + 6.0 * noise.Uniform()};
    const auto at = field.At(p);
    const bool on_edge = std::floor(p.x + 0.5 + kStep) != std::floor(p.x + 0.5) ||
                         std::floor(p.y + 0.5 + kStep) != std::floor(p.y + 0.5);
    if (on_edge) continue;
    EXPECT_NEAR(at.dx, (field.At({p.x + kStep, p.y}).value - at.value) / kStep, 1e-6);
    EXPECT_NEAR(at.dy, (field.At({p.x, p.y + kStep}).value - at.value) / kStep, 1e-6);
  }
  EXPECT_EQ(field.At({1e5, 0.0}).value, 0.0);
}

}  // namespace
}  // namespace slam2d
