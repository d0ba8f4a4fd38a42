#pragma once

#include <tuple>

#include "occupancy_map.hpp"
#include "revisit_detector.hpp"
#include "scan_matcher.hpp"
#include "tunable.hpp"

/// What users may tune, one line each. The bounds exclude values that cannot work, not values that work badly.
namespace slam2d {

template <>
struct Tunables<MapOptions> {
  using O = MapOptions;
  static constexpr std::tuple kAll{
      Tunable{"cell_size_m", &O::cell_size_m, "edge of a cell", "m", 0.01, 1, When::kAtStart},
      Tunable{"max_hit_range_m", &O::max_hit_range_m,
              "farther returns mark no obstacle and clear cells up to this range only", "m", 0, 1000},
      Tunable{"min_hit_range_m", &O::min_hit_range_m, "nearer returns are the robot itself", "m", 0, 1000},
      Tunable{"max_bridge_m", &O::max_bridge_m,
              "greatest gap between neighboring returns that is drawn as a wall; 0: none", "m", 0, 100},
      Tunable{"bridge_tolerance_m", &O::bridge_tolerance_m, "greatest deviation of such a wall from a line", "m", 0,
              10},
      Tunable{"min_bridge_offset_m", &O::min_bridge_offset_m, "least distance of the laser from such a wall's line",
              "m", 0, 100},
      Tunable{"hit_gain", &O::hit_gain, "added to a cell in which a beam ends", "", 0, 127},
      Tunable{"miss_loss", &O::miss_loss, "subtracted from a cell that beams only cross", "", 0, 127},
      Tunable{"max_value", &O::max_value, "upper clamp of a cell", "", 1, 127, When::kAtStart},
      Tunable{"min_value", &O::min_value, "lower clamp of a cell", "", -127, -1, When::kAtStart},
      Tunable{"min_translation_m", &O::min_translation_m,
              "a scan is drawn after this much motion since the last one drawn", "m", 0, 100},
      Tunable{"min_rotation_rad", &O::min_rotation_rad, "or after this much turning since then", "rad", 0, 7},
  };
};

template <>
struct Tunables<RevisitOptions> {
  using O = RevisitOptions;
  static constexpr std::tuple kAll{
      Tunable{"lag_m", &O::lag_m, "cells drawn within this much travel are not yet old", "m", 0, 100000},
      Tunable{"check_every_m", &O::check_every_m, "travel between two searches of the old map", "m", 0, 1000},
      Tunable{"half_width_m", &O::half_width_m, "half the search window along x and y", "m", 0, 20},
      Tunable{"half_width_per_m", &O::half_width_per_m,
              "its growth with travel since the pose last agreed with the old map", "m/m", 0, 10},
      Tunable{"max_half_width_m", &O::max_half_width_m, "greatest half window along x and y", "m", 0, 20},
      Tunable{"half_angle_rad", &O::half_angle_rad, "half the search window of the heading", "rad", 0, 3.2},
      Tunable{"half_angle_per_m", &O::half_angle_per_m, "its growth with that travel", "rad/m", 0, 10},
      Tunable{"max_half_angle_rad", &O::max_half_angle_rad, "greatest half window of the heading", "rad", 0, 3.2},
      Tunable{"angle_step_rad", &O::angle_step_rad, "grid of headings", "rad", 0.001, 1},
      Tunable{"cost_per_m2", &O::cost_per_m2, "score lost per squared distance from the tracked pose", "1/m^2", 0,
              1000},
      Tunable{"cost_per_rad2", &O::cost_per_rad2, "score lost per squared angle from the tracked heading", "1/rad^2", 0,
              1000},
      Tunable{"min_score", &O::min_score, "least mean likelihood to recognize a place", "", 0, 1},
      Tunable{"min_gain", &O::min_gain,
              "the tracked pose is doubted if it scores this much less than the recognized place", "", 0, 1},
      Tunable{"confirmations", &O::confirmations, "successive searches that must find the same correction", "", 1,
              1000},
      Tunable{"same_distance_m", &O::same_distance_m, "corrections are the same up to this distance", "m", 0, 10},
      Tunable{"same_angle_rad", &O::same_angle_rad, "corrections are the same up to this angle", "rad", 0, 3.2},
  };
};

template <>
struct Tunables<MatcherOptions> {
  using O = MatcherOptions;
  static constexpr std::tuple kAll{
      Tunable{"max_range_m", &O::max_range_m, "farther returns are not matched", "m", 0, 1000},
      Tunable{"min_range_m", &O::min_range_m, "nearer returns are the robot itself", "m", 0, 1000},
      Tunable{"point_spacing_m", &O::point_spacing_m, "points nearer to the last kept point are left out", "m", 0, 10},
      Tunable{"min_points", &O::min_points, "with fewer points only odometry is used", "", 4, 100000},
      Tunable{"field_sigma_m", &O::field_sigma_m, "smoothing of the likelihood field", "m", 0.01, 0.5, When::kAtStart},
      Tunable{"skip_translation_m", &O::skip_translation_m,
              "least motion between two matches, if there is little turning", "m", 0, 10},
      Tunable{"skip_rotation_rad", &O::skip_rotation_rad,
              "least turning between two matches, if there is little motion", "rad", 0, 3.2},
      Tunable{"half_width_m", &O::half_width_m, "half the search window along x and y", "m", 0, 5},
      Tunable{"half_width_per_m", &O::half_width_per_m, "its growth with the motion since the last match", "m/m", 0,
              10},
      Tunable{"max_half_width_m", &O::max_half_width_m, "greatest half window along x and y", "m", 0, 5},
      Tunable{"half_angle_rad", &O::half_angle_rad, "half the search window of the heading", "rad", 0, 3.2},
      Tunable{"half_angle_per_rad", &O::half_angle_per_rad, "its growth with the turning since the last match",
              "rad/rad", 0, 2},
      Tunable{"angle_step_rad", &O::angle_step_rad, "grid of headings; the refinement is finer", "rad", 0.001, 1},
      Tunable{"cost_per_m2", &O::cost_per_m2, "score lost per squared distance from the predicted pose", "1/m^2", 0,
              1000},
      Tunable{"cost_per_rad2", &O::cost_per_rad2, "score lost per squared angle from the predicted heading", "1/rad^2",
              0, 1000},
      Tunable{"min_score", &O::min_score, "below this score only odometry is used", "", 0, 1},
      Tunable{"max_refinements", &O::max_refinements, "Gauss-Newton steps after the search", "", 0, 1000},
      TunableGroup{"revisit", &O::revisit},
  };
};

}  // namespace slam2d
