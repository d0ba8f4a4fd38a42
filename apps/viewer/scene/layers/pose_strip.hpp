#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "viewer/data/frames/pose_list.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Draws poses as a line, as axes, or both. Each of the two is one draw call for any number of poses. Thread: the one
/// whose GL context is current.
class PoseStrip {
 public:
  PoseStrip();

  /// Call it when the poses from index `first` on have changed since the last call.
  void Set(std::span<const PoseList::Pose> poses, std::size_t first = 0);

  /// The line starting at pose `first`, including its connection to the pose before.
  void DrawLine(const ViewMatrices& view, const RigidTransform& T_fixed_poses, const std::array<float, 3>& color,
                float width_pixels, std::size_t first = 0);
  void DrawAxes(const ViewMatrices& view, const RigidTransform& T_fixed_poses, float length_meters, float width_pixels,
                std::size_t first = 0);

  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept { return capacity_ * sizeof(PoseList::Pose); }

 private:
  void Bind(std::size_t first_pose, bool with_next);

  ShaderProgram line_;
  ShaderProgram axes_;
  GlBuffer buffer_;
  GlVertexArray vertices_;
  std::size_t count_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace hgros::viewer
