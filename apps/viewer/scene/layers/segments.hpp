#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hgros/tf/rigid_transform.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Straight lines with one color each, all in one draw call.
class Segments {
 public:
  struct Segment {
    Eigen::Vector3f from;  ///< In the frame given when they are drawn.
    Eigen::Vector3f to;
    std::uint32_t color;  ///< Red in the lowest byte, alpha in the highest.
  };

  Segments();
  void Set(std::span<const Segment> segments);
  void Draw(const ViewMatrices& view, const RigidTransform& T_fixed_lines, float width_pixels);
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

 private:
  ShaderProgram program_;
  GlBuffer buffer_;
  GlVertexArray vertices_;
  std::size_t count_ = 0;
};

}  // namespace hgros::viewer
