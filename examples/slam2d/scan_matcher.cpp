#include "scan_matcher.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "correlative_search.hpp"

namespace slam2d {
namespace {

struct Linearized {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double cost = 0.0;
  double mean_value = 0.0;
};

// Sum of squared residuals 1 - M(T p) over the points, plus the pull toward the prediction.
Linearized Linearize(const LikelihoodField& field, const std::vector<Point2>& points, const Pose2& T,
                     const Pose2& T_predicted, const MatcherOptions& options) {
  Linearized sum;
  const double cells_per_m = 1.0 / field.cell_size_m();
  const double c = std::cos(T.theta);
  const double s = std::sin(T.theta);
  for (const Point2& p : points) {
    const Point2 turned{c * p.x - s * p.y, s * p.x + c * p.y};
    const LikelihoodField::Sample m = field.At({(T.x + turned.x) * cells_per_m, (T.y + turned.y) * cells_per_m});
    const double residual = 1.0 - m.value;
    const double jx = m.dx * cells_per_m;
    const double jy = m.dy * cells_per_m;
    const Eigen::Vector3d J(jx, jy, jy * turned.x - jx * turned.y);
    sum.H += J * J.transpose();
    sum.g += J * residual;
    sum.cost += residual * residual;
    sum.mean_value += m.value;
  }
  const auto n = static_cast<double>(points.size());
  const Eigen::Vector3d weight = n * Eigen::Vector3d(options.cost_per_m2, options.cost_per_m2, options.cost_per_rad2);
  const Eigen::Vector3d off(T.x - T_predicted.x, T.y - T_predicted.y, WrapAngle(T.theta - T_predicted.theta));
  sum.H.diagonal() += weight;
  sum.g -= weight.cwiseProduct(off);
  sum.cost += off.dot(weight.cwiseProduct(off));
  sum.mean_value /= n;
  return sum;
}

}  // namespace

std::vector<Point2> MatchedPoints(const LaserScan2& scan, const MatcherOptions& options) {
  std::vector<Point2> points;
  const double max_range = std::min(options.max_range_m, scan.max_range_m);
  const double spacing2 = options.point_spacing_m * options.point_spacing_m;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.ranges_m[i];
    if (range < options.min_range_m || range >= max_range) continue;
    const double angle = scan.start_angle_rad + static_cast<double>(i) * scan.angle_step_rad;
    const Point2 p{range * std::cos(angle), range * std::sin(angle)};
    if (!points.empty()) {
      const double dx = p.x - points.back().x;
      const double dy = p.y - points.back().y;
      if (dx * dx + dy * dy < spacing2) continue;
    }
    points.push_back(p);
  }
  return points;
}

ScanMatch RefineMatch(const LikelihoodField& field, const std::vector<Point2>& points, const Pose2& T_map_start,
                      const Pose2& T_map_predicted, const MatcherOptions& options) {
  Pose2 T = T_map_start;
  Linearized now = Linearize(field, points, T, T_map_predicted, options);
  double damping = 1e-3;
  for (int i = 0; i < options.max_refinements; ++i) {
    Eigen::Matrix3d H = now.H;
    H.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d step = H.inverse() * now.g;
    if (!step.allFinite()) break;
    const Pose2 next{T.x + step.x(), T.y + step.y(), WrapAngle(T.theta + step.z())};
    const Linearized then = Linearize(field, points, next, T_map_predicted, options);
    if (then.cost < now.cost) {
      const bool converged = now.cost - then.cost < 1e-6 * now.cost;
      T = next;
      now = then;
      damping *= 0.1;
      if (converged) break;
    } else {
      damping *= 10.0;
      if (damping > 1e3) break;
    }
  }
  ScanMatch match;
  match.T_map_laser = T;
  match.score = now.mean_value;
  const double variance = now.cost / std::max(1.0, static_cast<double>(points.size()) - 3.0);
  const Eigen::Matrix3d covariance = variance * now.H.inverse();
  match.covariance = {covariance(0, 0), covariance(0, 1), covariance(0, 2),
                      covariance(1, 1), covariance(1, 2), covariance(2, 2)};
  return match;
}

ScanMatcher::ScanMatcher(const MatcherOptions& matcher_options, const MapOptions& map_options)
    : options_(matcher_options),
      replica_(map_options),
      field_(map_options.cell_size_m, matcher_options.field_sigma_m),
      revisits_(matcher_options.revisit, map_options.cell_size_m, matcher_options.field_sigma_m) {}

void ScanMatcher::SetOptions(const MatcherOptions& options) {
  const double field_sigma_m = options_.field_sigma_m;
  options_ = options;
  options_.field_sigma_m = field_sigma_m;
  revisits_.SetOptions(options.revisit);
}

void ScanMatcher::SetMap(const OccupancyMap& map) {
  const double cell_size_m = map.options().cell_size_m;
  if (cell_size_m != replica_.options().cell_size_m) {
    replica_ = OccupancyMap(map.options());
    field_ = LikelihoodField(cell_size_m, options_.field_sigma_m);
    revisits_ = RevisitDetector(options_.revisit, cell_size_m, options_.field_sigma_m);
  }
  Apply(Difference(replica_, map));
}

void ScanMatcher::Apply(const MapDelta& delta) {
  replica_.Apply(delta);
  field_.Apply(delta);
  revisits_.Apply(delta, traveled_m_);
}

ScanMatch ScanMatcher::Match(const LaserScan2& scan) {
  ScanMatch match{scan.sequence, scan.stamp_seconds, scan.odometry, 0.0, true, {}};
  if (!started_) {
    started_ = true;
    last_sequence_ = scan.sequence;
    T_odometry_matched_ = T_map_matched_ = scan.odometry;
    return match;
  }
  if (replica_.version() != last_sequence_) {
    throw std::logic_error("Scan " + std::to_string(scan.sequence) + " needs the map after scan " +
                           std::to_string(last_sequence_) + ", but has the map after scan " +
                           std::to_string(replica_.version()) + ".");
  }
  last_sequence_ = scan.sequence;

  const Pose2 motion = Inverse(T_odometry_matched_) * scan.odometry;
  const Pose2 predicted = T_map_matched_ * motion;
  const double distance = Distance(motion);
  const double turn = std::abs(motion.theta);
  match.T_map_laser = predicted;
  if (distance < options_.skip_translation_m && turn < options_.skip_rotation_rad) return match;

  const std::vector<Point2> points = MatchedPoints(scan, options_);
  if (points.size() >= options_.min_points && !field_.empty()) {
    const SearchWindow window{
        std::min(options_.max_half_width_m, options_.half_width_m + options_.half_width_per_m * distance),
        options_.half_angle_rad + options_.half_angle_per_rad * turn, options_.angle_step_rad, options_.cost_per_m2,
        options_.cost_per_rad2};
    const SearchResult found = SearchCorrelative(field_, points, predicted, window, options_.min_score);
    if (found.score >= options_.min_score) {
      ScanMatch refined = RefineMatch(field_, points, found.T_map_laser, predicted, options_);
      const RevisitDetector::Verdict verdict = revisits_.Check(points, refined.T_map_laser, traveled_m_ + distance);
      if (verdict.T_map_laser) {
        refined = RefineMatch(revisits_.old_field(), points, *verdict.T_map_laser, *verdict.T_map_laser, options_);
      }
      match.drawable = !verdict.doubtful;
      match.T_map_laser = refined.T_map_laser;
      match.score = refined.score;
      match.covariance = refined.covariance;
    }
  }
  traveled_m_ += distance;
  T_odometry_matched_ = scan.odometry;
  T_map_matched_ = match.T_map_laser;
  return match;
}

}  // namespace slam2d
