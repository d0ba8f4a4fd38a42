#include "viewer/data/grid/voxel_reader.hpp"

#include <algorithm>
#include <utility>

#include "viewer/data/grid/cell_values.hpp"
#include "viewer/data/shapes/scene_reader.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMaxVoxels = 256UL << 20;

}  // namespace

std::string ReadVoxels(const Bulk<foxglove::VoxelGrid>& grid, std::string_view field, double threshold,
                       VoxelPicture& picture) {
  const foxglove::VoxelGrid& head = grid.head();
  const Bytes data = grid.bytes();
  if (head.fields_size() == 0) return "The voxel grid has no fields.";
  CellValues::Layout layout;
  layout.columns = head.column_count();
  layout.rows = head.row_count();
  layout.cell_stride = head.cell_stride();
  layout.row_stride = head.row_stride();
  layout.slice_stride = head.slice_stride();
  if (layout.slice_stride == 0 || layout.columns == 0 || layout.rows == 0) {
    return "The voxel grid has no columns or rows, or its slices have no bytes.";
  }
  layout.slices = data.size() / layout.slice_stride;
  if (layout.slices == 0) return "The voxel grid has no cells.";
  if (layout.rows > kMaxVoxels / layout.columns || layout.rows * layout.columns > kMaxVoxels / layout.slices) {
    return "The voxel grid has more than " + std::to_string(kMaxVoxels) + " cells.";
  }
  VoxelPicture read;
  read.frame = head.frame_id();
  read.stamp = StampOf(head.timestamp());
  read.cell_size = {head.cell_size().x(), head.cell_size().y(), head.cell_size().z()};
  if (!read.cell_size.allFinite() || read.cell_size.minCoeff() <= 0) return "The voxel grid's cells have no size.";
  if (head.has_pose() && !ReadPose(head.pose(), read.T_frame_corner)) return "The voxel grid's pose is not a number.";
  for (const auto& one : head.fields()) read.fields.push_back(one.name());
  auto chosen = head.fields().begin();
  if (!field.empty()) {
    chosen = std::ranges::find_if(head.fields(), [&](const auto& one) { return one.name() == field; });
    if (chosen == head.fields().end()) return "The voxel grid has no field \"" + std::string(field) + "\".";
  }
  const auto values =
      CellValues::Of(data, layout, {chosen->name(), chosen->offset(), static_cast<int>(chosen->type())});
  if (!values) return values.fault();
  read.field = chosen->name();
  read.counts = {layout.columns, layout.rows, layout.slices};

  const std::size_t columns = layout.columns, rows = layout.rows, slices = layout.slices;
  const std::size_t slice_cells = columns * rows;
  std::vector<bool> full(slice_cells * slices);
  for (std::size_t z = 0, i = 0; z < slices; ++z) {
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < columns; ++x, ++i) full[i] = values->At(x, y, z) > threshold;
    }
  }
  for (std::size_t z = 0, i = 0; z < slices; ++z) {
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < columns; ++x, ++i) {
        if (!full[i]) continue;
        ++read.occupied;
        unsigned faces = 0;
        const auto look = [&](unsigned bit, bool border, std::size_t neighbor) {
          if (border || !full[neighbor]) faces |= 1U << bit;
        };
        look(0, x == 0, i - 1);
        look(1, x + 1 == columns, i + 1);
        look(2, y == 0, i - columns);
        look(3, y + 1 == rows, i + columns);
        look(4, z == 0, i - slice_cells);
        look(5, z + 1 == slices, i + slice_cells);
        if (faces == 0) continue;
        read.cubes.push_back(
            {{static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(z)},
             static_cast<std::uint8_t>(faces),
             static_cast<float>(values->At(x, y, z))});
      }
    }
  }
  picture = std::move(read);
  return {};
}

}  // namespace hgros::viewer
