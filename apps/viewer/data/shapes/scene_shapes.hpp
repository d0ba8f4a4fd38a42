#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace hgros::viewer {

/// Red, green, blue and alpha, one byte each; red is the lowest byte.
using Rgba = std::uint32_t;
[[nodiscard]] constexpr Rgba MakeRgba(unsigned red, unsigned green, unsigned blue, unsigned alpha = 255) noexcept {
  return red | green << 8U | blue << 16U | alpha << 24U;
}
[[nodiscard]] constexpr unsigned AlphaOf(Rgba color) noexcept { return color >> 24U; }

/// A cube, sphere or cylinder of size 1 around the origin, moved and stretched.
struct SolidShape {
  Eigen::Matrix<double, 3, 4> pose;  ///< From the unit shape to the entity's frame or the drawing's frame.
  Rgba color = 0;
  float bottom_scale = 1;  ///< Cylinders: scale of the face at z = -0.5; 0 makes a cone.
  float top_scale = 1;     ///< The same at z = +0.5.
};

/// A straight piece of a line.
struct LinePiece {
  Eigen::Vector3d from, to;
  Rgba from_color = 0, to_color = 0;
  float thickness = 1;  ///< Meters or pixels.
  bool pixels = false;
};

struct TriangleCorner {
  Eigen::Vector3d position;
  Rgba color = 0;
};

/// Fully transparent: it is neither drawn nor picked.
[[nodiscard]] constexpr bool IsInvisible(const SolidShape& solid) noexcept { return AlphaOf(solid.color) == 0; }
[[nodiscard]] constexpr bool IsInvisible(const LinePiece& line) noexcept {
  return AlphaOf(line.from_color) == 0 && AlphaOf(line.to_color) == 0;
}
[[nodiscard]] constexpr bool IsInvisible(std::span<const TriangleCorner, 3> triangle) noexcept {
  return AlphaOf(triangle[0].color) == 0 && AlphaOf(triangle[1].color) == 0 && AlphaOf(triangle[2].color) == 0;
}

struct SceneText {
  Eigen::Matrix<double, 3, 4> pose;  ///< Text runs along x; its top points along y.
  std::string text;
  Rgba color = 0;
  double height = 0;  ///< Height of a line: meters or pixels.
  bool pixels = false;
  bool billboard = false;
};

/// A mesh from a file or a message.
struct SceneModel {
  Eigen::Matrix<double, 3, 4> pose;
  std::string url;  ///< Empty: `data` is the file.
  std::string media_type;
  std::string data;
  Rgba color = 0;
  bool override_color = false;
};

/// Shapes by kind: all shapes of a kind are one draw call.
struct SceneShapes {
  std::vector<SolidShape> cubes, spheres, cylinders;
  std::vector<LinePiece> lines;
  std::vector<TriangleCorner> triangles;  ///< Three each.
  std::vector<SceneText> texts;
  std::vector<SceneModel> models;

  /// Number of shapes.
  [[nodiscard]] std::size_t size() const noexcept {
    return cubes.size() + spheres.size() + cylinders.size() + lines.size() + triangles.size() / 3 + texts.size() +
           models.size();
  }
};

}  // namespace hgros::viewer
