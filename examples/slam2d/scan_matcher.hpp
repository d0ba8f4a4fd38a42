#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "laser_scan.hpp"
#include "likelihood_field.hpp"
#include "occupancy_map.hpp"
#include "pose2.hpp"
#include "revisit_detector.hpp"

namespace slam2d {

/// How scans are matched. tunables.hpp documents each number and its bounds.
struct MatcherOptions {
  double max_range_m = 25.0;
  double min_range_m = 0.1;
  double point_spacing_m = 0.08;
  std::size_t min_points = 20;
  double field_sigma_m = 0.05;
  double skip_translation_m = 0.02;
  double skip_rotation_rad = 0.01;
  double half_width_m = 0.15;
  double half_width_per_m = 0.4;
  double max_half_width_m = 0.5;
  double half_angle_rad = 0.12;
  double half_angle_per_rad = 0.5;
  double angle_step_rad = 0.0075;
  double cost_per_m2 = 4.0;
  double cost_per_rad2 = 0.4;  ///< Both costs decide where the walls allow several poses.
  double min_score = 0.25;
  int max_refinements = 12;
  RevisitOptions revisit;
};

/// The pose of a scan, and its uncertainty.
struct ScanMatch {
  std::uint64_t sequence = 0;
  double stamp_seconds = 0.0;
  Pose2 T_map_laser;
  double score = 0.0;                  ///< Mean likelihood of the matched points, 0..1; 0 if only odometry was used.
  bool drawable = true;                ///< False while the pose contradicts older parts of the map.
  std::array<double, 6> covariance{};  ///< Upper triangle over (x, y, theta), m^2, m rad, rad^2; 0 if not matched.

  friend bool operator==(const ScanMatch&, const ScanMatch&) = default;
};

/// The matched part of a scan as points in the laser frame: returns within the options' ranges, thinned so that near
/// walls, which many beams hit, do not outweigh far ones.
[[nodiscard]] std::vector<Point2> MatchedPoints(const LaserScan2& scan, const MatcherOptions& options);

/// Climbs from `T_map_start` to the nearest maximum of `field`'s smooth interpolation, by Gauss-Newton on the
/// residuals 1 - M(T p) (Kohlbrecher et al., A Flexible and Scalable SLAM System, SSRR 2011) with a pull toward
/// `T_map_predicted`. Returns the start itself if no step improves it. Leaves `sequence` and stamp 0.
[[nodiscard]] ScanMatch RefineMatch(const LikelihoodField& field, const std::vector<Point2>& points,
                                    const Pose2& T_map_start, const Pose2& T_map_predicted,
                                    const MatcherOptions& options);

/// Tracks the laser: matches every scan against a replica of the map, which is updated only by deltas.
///
/// The map for scan k is the one after scan k - 1: Match(k) must follow Apply of the delta with version k - 1.
/// Threading: one thread at a time.
class ScanMatcher {
 public:
  ScanMatcher(const MatcherOptions& matcher_options, const MapOptions& map_options);

  /// Matches scans with `options` from now on. The smoothing of the field stays unchanged.
  void SetOptions(const MatcherOptions& options);
  /// Goes on from the same pose with another map, which may have cells of another size. If `map` is what the next delta
  /// would make of the replica, this is the same as Apply() of that delta.
  void SetMap(const OccupancyMap& map);

  /// The pose of `scan`. The first scan's is its odometry.
  ///
  /// Errors: throws std::logic_error if the delta of the previous scan has not been applied.
  [[nodiscard]] ScanMatch Match(const LaserScan2& scan);

  /// Errors: throws std::invalid_argument like OccupancyMap::Apply.
  void Apply(const MapDelta& delta);

  [[nodiscard]] const OccupancyMap& replica() const { return replica_; }
  [[nodiscard]] const LikelihoodField& field() const { return field_; }

 private:
  MatcherOptions options_;
  OccupancyMap replica_;
  LikelihoodField field_;
  RevisitDetector revisits_;
  double traveled_m_ = 0.0;
  bool started_ = false;
  std::uint64_t last_sequence_ = 0;
  Pose2 T_odometry_matched_;  // Odometry and pose of the scan matched last.
  Pose2 T_map_matched_;
};

}  // namespace slam2d
