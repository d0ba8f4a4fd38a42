#include "viewer/data/shapes/scene_reader.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Eigen::Matrix<double, 3, 4> Stretched(const Isometry3d& pose, const Vector3d& size) {
  Eigen::Matrix<double, 3, 4> stretched = pose.matrix().topRows<3>();
  stretched.leftCols<3>() = pose.linear() * size.asDiagonal();
  return stretched;
}

Vector3d PointOf(const foxglove::Point3& point) { return {point.x(), point.y(), point.z()}; }

/// The order in which the points of a list are used, and their colors.
template <class Primitive>
class Vertices {
 public:
  explicit Vertices(const Primitive& primitive) : primitive_(primitive), color_(ReadColor(primitive.color())) {}

  /// Returns what is wrong, or nothing.
  [[nodiscard]] std::string Fault() const {
    const int points = primitive_.points_size();
    if (primitive_.colors_size() != 0 && primitive_.colors_size() != points) {
      return "has " + std::to_string(primitive_.colors_size()) + " colors for " + std::to_string(points) + " points";
    }
    for (const auto index : primitive_.indices()) {
      if (index >= static_cast<std::uint32_t>(points)) {
        return "uses point " + std::to_string(index) + " of " + std::to_string(points);
      }
    }
    return {};
  }
  [[nodiscard]] int size() const {
    return primitive_.indices_size() != 0 ? primitive_.indices_size() : primitive_.points_size();
  }
  [[nodiscard]] Vector3d Position(int i) const { return PointOf(primitive_.points(At(i))); }
  [[nodiscard]] Rgba Color(int i) const {
    return primitive_.colors_size() == 0 ? color_ : ReadColor(primitive_.colors(At(i)));
  }

 private:
  [[nodiscard]] int At(int i) const {
    return primitive_.indices_size() != 0 ? static_cast<int>(primitive_.indices(i)) : i;
  }
  const Primitive& primitive_;
  const Rgba color_;
};

// Each returns what is wrong, as the end of a sentence that begins "its line".

std::string Read(const foxglove::ArrowPrimitive& arrow, const Isometry3d& pose, SceneShapes& shapes) {
  const double lengths[] = {arrow.shaft_length(), arrow.shaft_diameter(), arrow.head_length(), arrow.head_diameter()};
  if (!std::ranges::all_of(lengths, [](double length) { return std::isfinite(length) && length >= 0; })) {
    return "has negative or invalid lengths";
  }
  const Rgba color = ReadColor(arrow.color());
  // Unit cylinders point along z, arrows along x.
  const Isometry3d along_x(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY()));
  const auto add = [&](double from, double length, double diameter, float top_scale) {
    if (length <= 0) return;
    const Isometry3d T = pose * Eigen::Translation3d(from + length / 2, 0, 0) * along_x;
    shapes.cylinders.push_back({Stretched(T, {diameter, diameter, length}), color, 1, top_scale});
  };
  add(0, arrow.shaft_length(), arrow.shaft_diameter(), 1);
  add(arrow.shaft_length(), arrow.head_length(), arrow.head_diameter(), 0);
  return {};
}

template <class Solid>
std::string ReadSolid(const Solid& solid, const Isometry3d& pose, std::vector<SolidShape>& to, float bottom = 1,
                      float top = 1) {
  const Vector3d size(solid.size().x(), solid.size().y(), solid.size().z());
  if (!size.allFinite()) return "has a size that is not a number";
  to.push_back({Stretched(pose, size), ReadColor(solid.color()), bottom, top});
  return {};
}

std::string Read(const foxglove::CubePrimitive& cube, const Isometry3d& pose, SceneShapes& shapes) {
  return ReadSolid(cube, pose, shapes.cubes);
}

std::string Read(const foxglove::SpherePrimitive& sphere, const Isometry3d& pose, SceneShapes& shapes) {
  return ReadSolid(sphere, pose, shapes.spheres);
}

std::string Read(const foxglove::CylinderPrimitive& cylinder, const Isometry3d& pose, SceneShapes& shapes) {
  const auto scale = [](double factor) {
    return std::isfinite(factor) ? static_cast<float>(std::clamp(factor, 0.0, 1.0)) : 0.0F;
  };
  return ReadSolid(cylinder, pose, shapes.cylinders, scale(cylinder.bottom_scale()), scale(cylinder.top_scale()));
}

std::string Read(const foxglove::LinePrimitive& line, const Isometry3d& pose, SceneShapes& shapes) {
  const Vertices vertices(line);
  if (std::string fault = vertices.Fault(); !fault.empty()) return fault;
  const bool list = line.type() == foxglove::LinePrimitive::LINE_LIST;
  const int count = vertices.size();
  const int pieces = list ? count / 2 : (line.type() == foxglove::LinePrimitive::LINE_LOOP ? count : count - 1);
  if (count < 2) return {};
  const double thickness = std::isfinite(line.thickness()) ? std::max(line.thickness(), 0.0) : 0.0;
  std::string fault;
  for (int i = 0; i < pieces; ++i) {
    const int from = list ? 2 * i : i;
    const int to = (from + 1) % count;
    const LinePiece piece{pose * vertices.Position(from), pose * vertices.Position(to),
                          vertices.Color(from),           vertices.Color(to),
                          static_cast<float>(thickness),  line.scale_invariant()};
    if (!piece.from.allFinite() || !piece.to.allFinite()) {
      fault = "has points that are not numbers";
    } else {
      shapes.lines.push_back(piece);
    }
  }
  return fault;
}

std::string Read(const foxglove::TriangleListPrimitive& list, const Isometry3d& pose, SceneShapes& shapes) {
  const Vertices vertices(list);
  if (std::string fault = vertices.Fault(); !fault.empty()) return fault;
  std::string fault;
  for (int i = 0; i + 2 < vertices.size(); i += 3) {
    const Vector3d corners[] = {pose * vertices.Position(i), pose * vertices.Position(i + 1),
                                pose * vertices.Position(i + 2)};
    if (!corners[0].allFinite() || !corners[1].allFinite() || !corners[2].allFinite()) {
      fault = "has points that are not numbers";
      continue;
    }
    for (int k = 0; k < 3; ++k) shapes.triangles.push_back({corners[k], vertices.Color(i + k)});
  }
  if (fault.empty() && vertices.size() % 3 != 0)
    fault = "has " + std::to_string(vertices.size()) + " corners, which is not a multiple of 3";
  return fault;
}

std::string Read(const foxglove::TextPrimitive& text, const Isometry3d& pose, SceneShapes& shapes) {
  if (!std::isfinite(text.font_size()) || text.font_size() < 0) return "has a size that is not a number";
  shapes.texts.push_back({pose.matrix().topRows<3>(), std::string(CutText(text.text())), ReadColor(text.color()),
                          text.font_size(), text.scale_invariant(), text.billboard()});
  return {};
}

std::string Read(const foxglove::ModelPrimitive& model, const Isometry3d& pose, SceneShapes& shapes) {
  const Vector3d scale(model.scale().x(), model.scale().y(), model.scale().z());
  if (!scale.allFinite()) return "has a scale that is not a number";
  if (model.url().empty() && model.data().empty()) return "names no file and has no data";
  shapes.models.push_back({Stretched(pose, scale), model.url(), model.media_type(), model.data(),
                           ReadColor(model.color()), model.override_color()});
  return {};
}

template <class Primitives>
void ReadAll(const Primitives& primitives, std::string_view kind, SceneShapes& shapes, std::string& first_fault) {
  for (int i = 0; i < primitives.size(); ++i) {
    Isometry3d pose = Isometry3d::Identity();
    std::string fault;
    if (primitives[i].has_pose() && !ReadPose(primitives[i].pose(), pose)) {
      fault = "has a pose that is not a number";
    } else {
      fault = Read(primitives[i], pose, shapes);
    }
    if (!fault.empty() && first_fault.empty()) {
      first_fault = std::string(kind) + " " + std::to_string(i) + " " + std::move(fault) + ".";
    }
  }
}

}  // namespace

Rgba ReadColor(const foxglove::Color& color) {
  const auto byte = [](double part) {
    return std::isfinite(part) ? static_cast<unsigned>(std::lround(std::clamp(part, 0.0, 1.0) * 255)) : 0U;
  };
  return MakeRgba(byte(color.r()), byte(color.g()), byte(color.b()), byte(color.a()));
}

bool ReadPose(const foxglove::Pose& pose, Isometry3d& T_parent_pose) {
  const auto& p = pose.position();
  const auto& q = pose.orientation();
  Eigen::Quaterniond rotation(q.w(), q.x(), q.y(), q.z());
  const Vector3d translation(p.x(), p.y(), p.z());
  if (!translation.allFinite() || !rotation.coeffs().allFinite()) return false;
  if (rotation.norm() < 1e-9) {
    rotation.setIdentity();
  } else {
    rotation.normalize();
  }
  T_parent_pose.setIdentity();
  T_parent_pose.linear() = rotation.toRotationMatrix();
  T_parent_pose.translation() = translation;
  return true;
}

std::string ReadScene(const foxglove::SceneEntity& entity, SceneShapes& shapes) {
  std::string fault;
  ReadAll(entity.arrows(), "Arrow", shapes, fault);
  ReadAll(entity.cubes(), "Cube", shapes, fault);
  ReadAll(entity.spheres(), "Sphere", shapes, fault);
  ReadAll(entity.cylinders(), "Cylinder", shapes, fault);
  ReadAll(entity.lines(), "Line", shapes, fault);
  ReadAll(entity.triangles(), "Triangle list", shapes, fault);
  ReadAll(entity.texts(), "Text", shapes, fault);
  ReadAll(entity.models(), "Model", shapes, fault);
  return fault;
}

}  // namespace hgros::viewer
