#include "revisit_detector.hpp"

#include <algorithm>
#include <cmath>

#include "correlative_search.hpp"

namespace slam2d {

RevisitDetector::RevisitDetector(const RevisitOptions& options, double cell_size_m, double field_sigma_m)
    : options_(options), old_field_(cell_size_m, field_sigma_m) {}

void RevisitDetector::Apply(const MapDelta& delta, double traveled_m) {
  if (!delta.tiles.empty()) recent_.push_back({traveled_m, delta});
  while (!recent_.empty() && recent_.front().traveled_m < traveled_m - options_.lag_m) {
    old_field_.Apply(recent_.front().delta);
    recent_.pop_front();
  }
}

RevisitDetector::Verdict RevisitDetector::Check(const std::vector<Point2>& points, const Pose2& T_map_tracked,
                                                double traveled_m) {
  if (traveled_m - checked_m_ < options_.check_every_m) return {last_.doubtful, {}};
  checked_m_ = traveled_m;
  last_ = {};
  if (old_field_.empty()) {
    agreed_m_ = traveled_m;
    return last_;
  }
  const double way = traveled_m - agreed_m_;
  const SearchWindow window{
      std::min(options_.max_half_width_m, options_.half_width_m + options_.half_width_per_m * way),
      std::min(options_.max_half_angle_rad, options_.half_angle_rad + options_.half_angle_per_m * way),
      options_.angle_step_rad, options_.cost_per_m2, options_.cost_per_rad2};
  const SearchResult found = SearchCorrelative(old_field_, points, T_map_tracked, window, options_.min_score);
  if (found.score < options_.min_score) {
    candidates_ = 0;
    return last_;
  }
  const SearchWindow here{0.05, 0.0, options_.angle_step_rad, 0.0, 0.0};
  if (found.score - SearchCorrelative(old_field_, points, T_map_tracked, here).score < options_.min_gain) {
    candidates_ = 0;
    agreed_m_ = traveled_m;
    return last_;
  }
  // Far from the map's origin, small errors of the heading would change the correction as a motion of that origin. So
  // it is compared as a motion of the laser.
  const Pose2 repeated = correction_ * T_map_tracked;
  const Pose2 off = Inverse(repeated) * found.T_map_laser;
  const bool same =
      candidates_ > 0 && Distance(off) < options_.same_distance_m && std::abs(off.theta) < options_.same_angle_rad;
  candidates_ = same ? candidates_ + 1 : 1;
  correction_ = found.T_map_laser * Inverse(T_map_tracked);
  last_.doubtful = true;
  if (candidates_ < options_.confirmations) return last_;
  candidates_ = 0;
  agreed_m_ = traveled_m;
  last_ = {};
  return {false, found.T_map_laser};
}

}  // namespace slam2d
