#include "viewer/view/point_picks.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

namespace hgros::viewer {
namespace {

int PlacesFor(double size) { return size < 1e4 ? 3 : size < 1e6 ? 2 : 1; }

}  // namespace

void PointPicks::Add(PickedPoint point) {
  if (points_.size() >= 2) points_.clear();
  points_.push_back(std::move(point));
}

std::optional<Measurement> PointPicks::measurement() const {
  if (points_.size() < 2) return std::nullopt;
  Measurement measured;
  measured.step = points_[1].at - points_[0].at;
  measured.distance = measured.step.norm();
  measured.in_plane = measured.step.head<2>().norm();
  return measured;
}

std::string MetersText(const Eigen::Vector3d& at) {
  const int places = PlacesFor(at.cwiseAbs().maxCoeff());
  char text[128];
  std::snprintf(text, sizeof text, "%.*f, %.*f, %.*f m", places, at.x(), places, at.y(), places, at.z());
  return text;
}

std::string MetersText(double length) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f m", PlacesFor(std::abs(length)), length);
  return text;
}

}  // namespace hgros::viewer
