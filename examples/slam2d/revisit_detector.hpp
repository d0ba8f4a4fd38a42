#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "likelihood_field.hpp"
#include "occupancy_map.hpp"
#include "pose2.hpp"

namespace slam2d {

struct RevisitOptions {
  double lag_m = 20.0;              ///< What was drawn within this much travel is not yet "old".
  double check_every_m = 0.2;       ///< Travel between two searches of the old map.
  double half_width_m = 0.4;        ///< Search window along x and y: this much ...
  double half_width_per_m = 0.02;   ///< ... and this much per m since the pose last agreed with the old map.
  double max_half_width_m = 2.5;    ///< At most so wide.
  double half_angle_rad = 0.05;     ///< Search window of the heading: this much ...
  double half_angle_per_m = 0.002;  ///< ... and this much per m since then.
  double max_half_angle_rad = 0.2;  ///< At most so wide.
  double angle_step_rad = 0.0075;
  double cost_per_m2 = 0.05;      ///< Score lost per squared distance from the tracked pose ...
  double cost_per_rad2 = 1.0;     ///< ... and per squared angle.
  double min_score = 0.6;         ///< A place is recognised from this mean likelihood on ...
  double min_gain = 0.12;         ///< ... and the tracked pose doubted if it scores this much less.
  int confirmations = 5;          ///< Successive searches that must find the same correction ...
  double same_distance_m = 0.25;  ///< ... up to this distance ...
  double same_angle_rad = 0.04;   ///< ... and angle.
};

/// Notices that the laser is back at a place mapped long ago, and that the tracked pose has drifted since.
///
/// It keeps a second likelihood field that trails the map by `lag_m` of travel and so holds the old walls only; in new
/// surroundings nothing matches it. The farther the way since the pose last agreed with it, the wider it searches.
/// A correction must be found several times in a row before it is believed.
///
/// Threading: one thread at a time.
class RevisitDetector {
 public:
  RevisitDetector(const RevisitOptions& options, double cell_size_m, double field_sigma_m);

  struct Verdict {
    bool doubtful = false;             ///< The tracked pose contradicts the old map; do not draw from it.
    std::optional<Pose2> T_map_laser;  ///< Set when the contradiction is confirmed: the place in the old map.
  };

  /// Checks the tracked pose of a scan whose points are `points`. `travelled_m` grows along the way.
  Verdict Check(const std::vector<Point2>& points, const Pose2& T_map_tracked, double travelled_m);

  /// Takes note of a map delta that was drawn at `travelled_m`.
  void Apply(const MapDelta& delta, double travelled_m);

  [[nodiscard]] const LikelihoodField& old_field() const { return old_field_; }

 private:
  struct Recent {
    double travelled_m;
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
