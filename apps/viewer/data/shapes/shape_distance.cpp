#include "viewer/data/shapes/shape_distance.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace hgros::viewer {
namespace {

using Eigen::Vector3d;

constexpr double kNowhere = std::numeric_limits<double>::infinity();

double FromPiece(const Vector3d& at, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length = along.squaredNorm();
  const double share = length > 0 ? std::clamp((at - from).dot(along) / length, 0.0, 1.0) : 0;
  return (at - from - share * along).norm();
}

/// `nearest` gives the surface points that may be nearest to a point of the unit shape.
template <class Nearest>
double FromSolids(const std::vector<SolidShape>& solids, const Vector3d& at, const Nearest& nearest) {
  double distance = kNowhere;
  for (const SolidShape& solid : solids) {
    if (IsInvisible(solid)) continue;
    const Eigen::Matrix3d stretch = solid.pose.leftCols<3>();
    Eigen::Matrix3d back;
    bool invertible = false;
    stretch.computeInverseWithCheck(back, invertible, 0.0);
    if (!invertible) continue;
    nearest(solid, Vector3d(back * (at - solid.pose.col(3))), [&](const Vector3d& point) {
      distance = std::min(distance, (stretch * point + solid.pose.col(3) - at).norm());
    });
  }
  return distance;
}

}  // namespace

double DistanceToTriangle(const Vector3d& at, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double edges = std::min({FromPiece(at, a, b), FromPiece(at, b, c), FromPiece(at, c, a)});
  const Vector3d normal = (b - a).cross(c - a);
  const double area = normal.norm();
  if (!(area > 0)) return edges;
  const auto inside = [&](const Vector3d& from, const Vector3d& to) {
    return (to - from).cross(at - from).dot(normal) >= 0;
  };
  if (!inside(a, b) || !inside(b, c) || !inside(c, a)) return edges;
  return std::abs((at - a).dot(normal)) / area;
}

double DistanceTo(const SceneShapes& shapes, const Vector3d& at) {
  double distance = FromSolids(shapes.cubes, at, [](const SolidShape&, const Vector3d& point, const auto& offer) {
    const Vector3d inside = point.cwiseMax(-0.5).cwiseMin(0.5);
    for (int axis = 0; axis < 3; ++axis) {
      for (const double face : {-0.5, 0.5}) {
        Vector3d on_face = inside;
        on_face[axis] = face;
        offer(on_face);
      }
    }
  });
  distance = std::min(distance,
                      FromSolids(shapes.spheres, at, [](const SolidShape&, const Vector3d& point, const auto& offer) {
                        const double radius = point.norm();
                        offer(radius > 0 ? Vector3d(0.5 / radius * point) : Vector3d(0.5, 0, 0));
                      }));
  distance = std::min(
      distance, FromSolids(shapes.cylinders, at, [](const SolidShape& solid, const Vector3d& point, const auto& offer) {
        const double radius = std::hypot(point.x(), point.y());
        const Vector3d outwards = radius > 0 ? Vector3d(point.x() / radius, point.y() / radius, 0) : Vector3d::UnitX();
        const auto limit = [&](double z) {
          const auto bottom = static_cast<double>(solid.bottom_scale);
          return 0.5 * (bottom + (static_cast<double>(solid.top_scale) - bottom) * (z + 0.5));
        };
        const double height = std::clamp(point.z(), -0.5, 0.5);
        offer(limit(height) * outwards + height * Vector3d::UnitZ());
        for (const double face : {-0.5, 0.5})
          offer(std::min(radius, limit(face)) * outwards + face * Vector3d::UnitZ());
      }));
  for (const LinePiece& line : shapes.lines) {
    if (IsInvisible(line)) continue;
    const double thick = line.pixels ? 0 : 0.5 * static_cast<double>(line.thickness);
    distance = std::min(distance, std::max(0.0, FromPiece(at, line.from, line.to) - thick));
  }
  for (std::size_t i = 0; i + 2 < shapes.triangles.size(); i += 3) {
    const std::span<const TriangleCorner, 3> corner(&shapes.triangles[i], 3);
    if (IsInvisible(corner)) continue;
    distance = std::min(distance, DistanceToTriangle(at, corner[0].position, corner[1].position, corner[2].position));
  }
  return distance;
}

}  // namespace hgros::viewer
