#pragma once

#include <vector>

#include "likelihood_field.hpp"
#include "pose2.hpp"

namespace slam2d {

/// The poses a search considers: a grid around its centre, and how much straying from the centre costs.
struct SearchWindow {
  double half_width_m = 0.2;  ///< Along x and along y.
  double half_angle_rad = 0.1;
  double angle_step_rad = 0.0075;
  double cost_per_m2 = 0.0;    ///< Subtracted from the score, per squared distance ...
  double cost_per_rad2 = 0.0;  ///< ... and per squared angle from the centre.
};

struct SearchResult {
  Pose2 T_map_laser;
  double score = -1.0;  ///< Mean field value over all points, 0..1, less the costs. -1: no pose reached `min_score`.
};

/// The pose of the window at which the field's mean over the points' cells, less the costs, is greatest.
///
/// Exhaustive in effect: branch and bound over the field's coarse levels leaves out only what cannot win. Among equal
/// scores the smallest (angle, y, x) wins, so the result does not depend on the order of the search.
/// Points: laser frame, m; the translation grid is the field's cells. Points outside of the field count 0.
[[nodiscard]] SearchResult SearchCorrelative(const LikelihoodField& field, const std::vector<Point2>& points,
                                             const Pose2& T_map_centre, const SearchWindow& window,
                                             double min_score = 0.0);

}  // namespace slam2d
