#include "viewer/data/shapes/shape_reader.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "viewer/data/shapes/polygon_triangles.hpp"
#include "viewer/data/shapes/scene_reader.hpp"

namespace hgros::viewer {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kOvalCorners = 48;
constexpr float kUsualPixels = 3;

struct Pen {
  Isometry3d pose;
  Rgba color;
  SceneShapes& shapes;

  void Triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) const {
    for (const Vector3d& corner : {a, b, c}) shapes.triangles.push_back({pose * corner, color});
  }
};

bool IsLength(double length) { return std::isfinite(length) && length >= 0; }

float PixelsOf(double width) { return width > 0 ? static_cast<float>(std::min(width, 1000.0)) : kUsualPixels; }

std::vector<Vector2d> CornersOf(const OvalShape& oval) {
  std::vector<Vector2d> corners;
  for (int i = 0; i < kOvalCorners; ++i) {
    const double angle = 2 * M_PI * i / kOvalCorners;
    corners.emplace_back(oval.a() * std::cos(angle), oval.b() * std::sin(angle));
  }
  return corners;
}

std::vector<Vector2d> CornersOf(const PolygonShape& polygon) {
  std::vector<Vector2d> corners;
  for (const auto& corner : polygon.corners()) corners.emplace_back(corner.x(), corner.y());
  return corners;
}

Vector3d At(const Vector2d& corner, double z) { return {corner.x(), corner.y(), z}; }

// Each returns what is wrong, as the end of a sentence that begins "The shape".

std::string DrawFlat(const std::vector<Vector2d>& corners, double z, const Pen& pen) {
  const auto triangles = TrianglesOf(corners);
  if (triangles.empty()) return "has no area";
  for (const auto& [a, b, c] : triangles) pen.Triangle(At(corners[a], z), At(corners[b], z), At(corners[c], z));
  return {};
}

std::string Draw(const PointShape& point, const Pen& pen) {
  const Vector3d at(point.position().x(), point.position().y(), point.position().z());
  if (!at.allFinite()) return "has a place that is not a number";
  const Vector3d moved = pen.pose * at;
  pen.shapes.lines.push_back({moved, moved, pen.color, pen.color, PixelsOf(point.width()), true});
  return {};
}

std::string Draw(const LineShape& line, const Pen& pen) {
  std::vector<Vector3d> points;
  for (const auto& point : line.points()) points.push_back(pen.pose * Vector3d(point.x(), point.y(), point.z()));
  if (!std::ranges::all_of(points, [](const Vector3d& point) { return point.allFinite(); })) {
    return "has points that are not numbers";
  }
  for (std::size_t i = 1; i < points.size(); ++i) {
    pen.shapes.lines.push_back({points[i - 1], points[i], pen.color, pen.color, PixelsOf(line.width()), true});
  }
  return {};
}

std::string Draw(const PolygonShape& polygon, const Pen& pen) { return DrawFlat(CornersOf(polygon), 0, pen); }

std::string Draw(const OvalShape& oval, const Pen& pen) {
  if (!IsLength(oval.a()) || !IsLength(oval.b())) return "has half axes that are not lengths";
  return DrawFlat(CornersOf(oval), 0, pen);
}

void AddSolid(std::vector<SolidShape>& to, const Pen& pen, const Vector3d& size, double z, float top_scale = 1) {
  SolidShape& solid = to.emplace_back();
  solid.pose = (pen.pose * Eigen::Translation3d(0, 0, z)).matrix().topRows<3>();
  solid.pose.leftCols<3>() = pen.pose.linear() * size.asDiagonal();
  solid.color = pen.color;
  solid.top_scale = top_scale;
}

std::string Draw(const EllipsoidShape& ellipsoid, const Pen& pen) {
  const Vector3d half(ellipsoid.half_axes().x(), ellipsoid.half_axes().y(), ellipsoid.half_axes().z());
  if (!half.allFinite() || half.minCoeff() < 0) return "has half axes that are not lengths";
  AddSolid(pen.shapes.spheres, pen, 2 * half, 0);
  return {};
}

std::string DrawUpright(const OvalShape& base, double height, float top_scale, const Pen& pen) {
  if (!IsLength(base.a()) || !IsLength(base.b())) return "has half axes that are not lengths";
  AddSolid(pen.shapes.cylinders, pen, {2 * base.a(), 2 * base.b(), height}, height / 2, top_scale);
  return {};
}

std::string Draw(const ConeShape& cone, const Pen& pen) {
  if (!std::isfinite(cone.height())) return "has a height that is not a number";
  return DrawUpright(cone.base(), cone.height(), 0, pen);
}

std::string Draw(const ExtrusionShape& extrusion, const Pen& pen) {
  const double height = extrusion.height();
  if (!std::isfinite(height)) return "has a height that is not a number";
  if (extrusion.base_case() == ExtrusionShape::kOval) return DrawUpright(extrusion.oval(), height, 1, pen);
  const std::vector<Vector2d> corners = CornersOf(extrusion.polygon());
  if (std::string fault = DrawFlat(corners, 0, pen); !fault.empty()) return fault;
  (void)DrawFlat(corners, height, pen);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d &from = corners[i], &to = corners[(i + 1) % corners.size()];
    pen.Triangle(At(from, 0), At(to, 0), At(to, height));
    pen.Triangle(At(from, 0), At(to, height), At(from, height));
  }
  return {};
}

std::string Draw(const Shape& shape, const Pen& pen) {
  switch (shape.shape_case()) {
    case Shape::kPoint: return Draw(shape.point(), pen);
    case Shape::kLine: return Draw(shape.line(), pen);
    case Shape::kPolygon: return Draw(shape.polygon(), pen);
    case Shape::kOval: return Draw(shape.oval(), pen);
    case Shape::kEllipsoid: return Draw(shape.ellipsoid(), pen);
    case Shape::kCone: return Draw(shape.cone(), pen);
    case Shape::kExtrusion: return Draw(shape.extrusion(), pen);
    case Shape::SHAPE_NOT_SET: break;
  }
  return "is of an unknown kind";
}

}  // namespace

std::string ReadShape(const Shape& shape, SceneShapes& shapes) {
  const auto sentence = [](const std::string& fault) { return "The shape " + fault + "."; };
  Isometry3d pose = Isometry3d::Identity();
  if (shape.has_pose() && !ReadPose(shape.pose(), pose)) return sentence("has a pose that is not a number");
  const std::string fault = Draw(shape, {pose, ReadColor(shape.color()), shapes});
  return fault.empty() ? fault : sentence(fault);
}

}  // namespace hgros::viewer
