#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"

namespace hgros::viewer {

/// A picture in the plane z = 0 of a frame: the first pixel is at the origin and rows run along x. Large pictures use
/// several textures. Thread: the one whose GL context is current.
class PictureTiles {
 public:
  /// `most_pixels`: the longest side of a texture, or the driver's limit if that is less.
  explicit PictureTiles(std::size_t most_pixels = 4096);

  /// Colors must be premultiplied by alpha, so that transparent pixels have no effect when several pixels become one.
  void Set(std::span<const Rgba> pixels, std::size_t columns, std::size_t rows);
  /// `pixel_meters`: the size of a pixel along x and y. With `blended` it hides nothing that is drawn later, unless the
  /// context has marks_depth.
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const Eigen::Vector2d& pixel_meters,
            float alpha, bool blended);
  [[nodiscard]] std::size_t tiles() const noexcept { return tiles_.size(); }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept { return columns_ * rows_ * 4 * 4 / 3; }

 private:
  struct Tile {
    GlTexture texture;
    std::size_t column, row, columns, rows;
  };
  void Cut(std::size_t columns, std::size_t rows);

  std::size_t most_pixels_;
  ShaderProgram program_;
  GlVertexArray corners_;  ///< Has no attributes; GL needs one.
  std::vector<Tile> tiles_;
  std::size_t columns_ = 0, rows_ = 0;
};

}  // namespace hgros::viewer
