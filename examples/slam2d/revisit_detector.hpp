#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "likelihood_field.hpp"
#include "occupancy_map.hpp"
#include "pose2.hpp"

namespace slam2d {

/// How known places are recognized. tunables.hpp documents each number and its bounds.
struct RevisitOptions {
  double lag_m = 20.0;
  double check_every_m = 0.2;
  double half_width_m = 0.4;
  double half_width_per_m = 0.02;
  double max_half_width_m = 2.5;
  double half_angle_rad = 0.05;
  double half_angle_per_m = 0.002;
  double max_half_angle_rad = 0.2;
  double angle_step_rad = 0.0075;
  double cost_per_m2 = 0.05;
  double cost_per_rad2 = 1.0;
  double min_score = 0.6;
  double min_gain = 0.12;
  int confirmations = 5;
  double same_distance_m = 0.25;
  double same_angle_rad = 0.04;
};

/// Detects that the laser is back at a place mapped long ago, and that the tracked pose has drifted since.
///
/// It keeps a second likelihood field that is `lag_m` of travel behind the map, so it contains only the old walls. In
/// new surroundings nothing matches it. The search window grows with the distance since the pose last agreed with it. A
/// correction must be found several times in a row before it is accepted.
///
/// Threading: one thread at a time.
class RevisitDetector {
 public:
  RevisitDetector(const RevisitOptions& options, double cell_size_m, double field_sigma_m);

  /// Takes effect with the next Check() and Apply(). What is already old stays old.
  void SetOptions(const RevisitOptions& options) { options_ = options; }

  struct Verdict {
    bool doubtful = false;             ///< The tracked pose contradicts the old map; do not draw from it.
    std::optional<Pose2> T_map_laser;  ///< Set when the contradiction is confirmed: the pose in the old map.
  };

  /// Checks the tracked pose of a scan with the points `points`. `traveled_m` must not decrease.
  Verdict Check(const std::vector<Point2>& points, const Pose2& T_map_tracked, double traveled_m);

  /// Adds a map delta that was drawn at `traveled_m`.
  void Apply(const MapDelta& delta, double traveled_m);

  [[nodiscard]] const LikelihoodField& old_field() const { return old_field_; }

 private:
  struct Recent {
    double traveled_m;
    MapDelta delta;
  };

  RevisitOptions options_;
  LikelihoodField old_field_;
  std::deque<Recent> recent_;
  double checked_m_ = 0.0;
  double agreed_m_ = 0.0;
  int candidates_ = 0;  // Successive searches that found correction_.
  Pose2 correction_;    // T_old_tracked
  Verdict last_;
};

}  // namespace slam2d
