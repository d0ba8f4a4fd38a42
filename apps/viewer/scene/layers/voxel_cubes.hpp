#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "viewer/data/grid/voxel_reader.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/gl/gl_object.hpp"
#include "viewer/scene/gl/shader_program.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/gl/software_renderer.hpp"

namespace hgros::viewer {

/// How voxels get their colors.
struct VoxelStyle {
  enum class ColorBy : std::uint8_t { kFlat, kHeight, kValue };
  ColorBy color_by = ColorBy::kHeight;
  std::array<float, 3> flat{};
  int map = 0;
  double lo = 0, hi = 1;  ///< Heights in the fixed frame, or values, of the first and the last color.
  float alpha = 1;
};

/// Cubes of a grid: 12 bytes each. The GPU makes the faces that border an empty voxel and are turned toward the eye.
/// Thread: the one whose GL context is current.
class VoxelCubes {
 public:
  static constexpr std::size_t kMostInARow = 65536;  ///< Largest number of cells along each axis.

  VoxelCubes();
  void Set(const VoxelPicture& voxels);
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const VoxelStyle& style,
            const Slice& slice, bool blended);
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] std::size_t gpu_bytes() const noexcept { return count_ * sizeof(Cube); }

 private:
  struct Cube {
    std::array<std::uint16_t, 3> cell;
    std::uint16_t faces;
    float value;
  };

  ShaderProgram program_;
  GlBuffer buffer_;
  GlVertexArray vertices_;
  DrawnPoints drawn_;
  Eigen::Vector3d cell_size_ = Eigen::Vector3d::Ones();
  std::size_t count_ = 0;
};

}  // namespace hgros::viewer
