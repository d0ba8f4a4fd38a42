#include "correlative_search.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scan_matcher.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

// Tries every pose of the window, without coarse levels.
SearchResult BruteForce(const LikelihoodField& field, const std::vector<Point2>& points, const Pose2& center,
                        const SearchWindow& window) {
  SearchResult best;
  const double cell = field.cell_size_m();
  const int n = static_cast<int>(std::lround(window.half_width_m / cell));
  const int angles = static_cast<int>(std::lround(window.half_angle_rad / window.angle_step_rad));
  for (int a = -angles; a <= angles; ++a) {
    const double angle = a * window.angle_step_rad;
    const double c = std::cos(center.theta + angle);
    const double s = std::sin(center.theta + angle);
    for (int y = -n; y <= n; ++y) {
      for (int x = -n; x <= n; ++x) {
        double sum = 0.0;
        for (const Point2& p : points) {
          const int px = static_cast<int>(std::floor((center.x + c * p.x - s * p.y) / cell)) + x;
          const int py = static_cast<int>(std::floor((center.y + s * p.x + c * p.y) / cell)) + y;
          if (field.level(0).Holds(px, py)) sum += field.level(0).values[field.level(0).Index(px, py)];
        }
        const double score = sum / (255.0 * static_cast<double>(points.size())) -
                             window.cost_per_m2 * cell * cell * (x * x + y * y) - window.cost_per_rad2 * angle * angle;
        if (score > best.score + 1e-9) {
          best = {{center.x + x * cell, center.y + y * cell, WrapAngle(center.theta + angle)}, score};
        }
      }
    }
  }
  return best;
}

class MappedStart : public testing::Test {
 protected:
  MappedStart() : field_(map_.options().cell_size_m, 0.08) {
    SimulatedBuilding building({.scans = 25});
    LaserScan2 scan;
    while (building.Next(scan)) field_.Apply(map_.Integrate(scan, building.true_pose()));
    true_pose_ = building.true_pose();
    points_ = MatchedPoints(scan, {});
  }

  OccupancyMap map_;
  LikelihoodField field_;
  Pose2 true_pose_;
  std::vector<Point2> points_;
};

TEST_F(MappedStart, CorrelativeSearchFindsTheSamePoseAsBruteForce) {
  SeededNoise noise(11);
  for (int i = 0; i < 4; ++i) {
    const SearchWindow window{i % 2 == 0 ? 0.2 : 0.6, 0.06, 0.02, i < 2 ? 0.0 : 4.0, i < 2 ? 0.0 : 0.4};
    const Pose2 center{true_pose_.x + 0.2 * noise.Normal(), true_pose_.y + 0.2 * noise.Normal(),
                       true_pose_.theta + 0.03 * noise.Normal()};
    const SearchResult expected = BruteForce(field_, points_, center, window);
    const SearchResult found = SearchCorrelative(field_, points_, center, window);
    EXPECT_NEAR(found.score, expected.score, 1e-9);
    EXPECT_NEAR(found.T_map_laser.x, expected.T_map_laser.x, 1e-9);
    EXPECT_NEAR(found.T_map_laser.y, expected.T_map_laser.y, 1e-9);
    EXPECT_NEAR(found.T_map_laser.theta, expected.T_map_laser.theta, 1e-9);
  }
}

TEST_F(MappedStart, CorrelativeSearchAndRefinementRecoverKnownOffsets) {
  MatcherOptions options;
  options.cost_per_m2 = options.cost_per_rad2 = 0.0;
  for (const Pose2& offset : {Pose2{0.3, -0.2, 0.1}, Pose2{-0.4, 0.35, -0.15}, Pose2{0.0, 0.0, 0.18}}) {
    const Pose2 start = true_pose_ * offset;
    const SearchResult found = SearchCorrelative(field_, points_, start, {0.6, 0.2, 0.0075, 0.0, 0.0});
    const ScanMatch match = RefineMatch(field_, points_, found.T_map_laser, found.T_map_laser, options);
    const Pose2 error = Inverse(true_pose_) * match.T_map_laser;
    EXPECT_LT(Distance(error), 0.03) << "offset " << offset.x << " " << offset.y << " " << offset.theta;
    EXPECT_LT(std::abs(error.theta), 0.005);
    EXPECT_GT(match.score, 0.7);
    EXPECT_GT(match.covariance[0], 0.0);
    EXPECT_LT(match.covariance[0], 1e-2);
  }
}

TEST_F(MappedStart, CorrelativeSearchFindsNoPoseBelowTheMinimumScore) {
  const SearchWindow window{0.2, 0.05, 0.01, 0.0, 0.0};
  EXPECT_EQ(SearchCorrelative(field_, points_, {500.0, 500.0, 0.0}, window, 0.1).score, -1.0);
  EXPECT_EQ(SearchCorrelative(field_, points_, true_pose_, window, 1.01).score, -1.0);
  EXPECT_EQ(SearchCorrelative(field_, {}, true_pose_, window).score, -1.0);
}

}  // namespace
}  // namespace slam2d
