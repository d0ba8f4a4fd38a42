#pragma once

#include <vector>

#include "likelihood_field.hpp"
#include "pose2.hpp"

namespace slam2d {

/// The poses that a search considers: a grid around its center, and the cost of distance from the center.
struct SearchWindow {
  double half_width_m = 0.2;  ///< Along x and along y.
  double half_angle_rad = 0.1;
  double angle_step_rad = 0.0075;
  double cost_per_m2 = 0.0;    ///< Subtracted from the score, per squared distance ...
  double cost_per_rad2 = 0.0;  ///< ... and per squared angle from the center.
};

struct SearchResult {
  Pose2 T_map_laser;
  double score = -1.0;  ///< Mean field value over all points, 0..1, minus the costs. -1: no pose reached `min_score`.
};

/// The pose of the window with the greatest mean of the field over the points' cells, minus the costs.
///
/// Equivalent to an exhaustive search: branch and bound over the field's coarse levels skips only poses that cannot
/// win. Among equal scores the smallest (angle, y, x) wins, so the result does not depend on the order of the search.
/// Points: laser frame, m. The translation grid is the field's cells. Points outside the field count 0.
[[nodiscard]] SearchResult SearchCorrelative(const LikelihoodField& field, const std::vector<Point2>& points,
                                             const Pose2& T_map_center, const SearchWindow& window,
                                             double min_score = 0.0);

}  // namespace slam2d
