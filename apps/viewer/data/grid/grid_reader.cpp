#include "viewer/data/grid/grid_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "viewer/data/grid/cell_values.hpp"
#include "viewer/data/shapes/scene_reader.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMaxGridCells = 64UL << 20;
constexpr std::array<std::string_view, 4> kColorNames = {"red", "green", "blue", "alpha"};

ElementField FieldOf(const foxglove::PackedElementField& field) {
  return {field.name(), field.offset(), static_cast<int>(field.type())};
}

bool IsByte(NumericType type) { return type == NumericType::kUint8 || type == NumericType::kInt8; }

// Returns what is wrong, or nothing.
std::string Color(Bytes data, const CellValues::Layout& layout, const foxglove::Grid& head, GridPicture& picture) {
  std::array<std::optional<CellValues>, 4> parts;
  for (std::size_t i = 0; i < kColorNames.size(); ++i) {
    const auto found =
        std::ranges::find_if(head.fields(), [&](const auto& one) { return one.name() == kColorNames[i]; });
    if (found == head.fields().end()) continue;
    auto values = CellValues::Of(data, layout, FieldOf(*found));
    if (!values) return values.fault();
    if (values->type() != NumericType::kUint8) return "The colors of its cells are not bytes.";
    parts[i] = *std::move(values);
  }
  for (std::size_t row = 0; row < layout.rows; ++row) {
    for (std::size_t column = 0; column < layout.columns; ++column) {
      const auto part = [&](std::size_t i, unsigned none) {
        return parts[i] ? static_cast<unsigned>(parts[i]->At(column, row)) : none;
      };
      picture.pixels.push_back(MakeRgba(part(0, 0), part(1, 0), part(2, 0), part(3, 255)));
    }
  }
  picture.colored = true;
  return {};
}

void Paint(const CellValues& values, GridPalette palette, GridPicture& picture) {
  const auto& layout = values.layout();
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  if (palette == GridPalette::kRaw) {
    for (std::size_t row = 0; row < layout.rows; ++row) {
      for (std::size_t column = 0; column < layout.columns; ++column) {
        const double value = values.At(column, row);
        if (!std::isfinite(value)) continue;
        least = std::min(least, value);
        greatest = std::max(greatest, value);
      }
    }
  }
  for (std::size_t row = 0; row < layout.rows; ++row) {
    for (std::size_t column = 0; column < layout.columns; ++column) {
      const double value = values.At(column, row);
      picture.pixels.push_back(palette == GridPalette::kRaw ? GrayOfCell(value, least, greatest)
                                                            : ColorOfCell(palette, value));
    }
  }
}

}  // namespace

std::string ReadGrid(const Bulk<foxglove::Grid>& grid, std::string_view field, std::optional<GridPalette> palette,
                     GridPicture& picture) {
  const foxglove::Grid& head = grid.head();
  const Bytes data = grid.bytes();
  if (head.fields_size() == 0) return "The grid has no fields.";
  CellValues::Layout layout;
  layout.columns = head.column_count();
  layout.cell_stride = head.cell_stride();
  layout.row_stride = head.row_stride();
  if (layout.row_stride == 0 || layout.columns == 0) return "The grid has no columns, or its rows have no bytes.";
  layout.rows = data.size() / layout.row_stride;
  // The last row may have no padding.
  if (data.size() % layout.row_stride >= layout.columns * layout.cell_stride && layout.cell_stride > 0) ++layout.rows;
  if (layout.rows == 0) return "The grid has no cells.";
  if (layout.columns > kMaxGridCells / layout.rows) {
    return "The grid has more than " + std::to_string(kMaxGridCells) + " cells.";
  }
  GridPicture read;
  read.frame = head.frame_id();
  read.stamp = StampOf(head.timestamp());
  read.cell_size = {head.cell_size().x(), head.cell_size().y()};
  if (!read.cell_size.allFinite() || read.cell_size.minCoeff() <= 0) return "The grid's cells have no size.";
  if (head.has_pose() && !ReadPose(head.pose(), read.T_frame_corner)) return "The grid's pose is not a number.";
  read.columns = layout.columns;
  read.rows = layout.rows;
  for (const auto& one : head.fields()) read.fields.push_back(one.name());
  const auto has = [&](std::string_view name) { return std::ranges::find(read.fields, name) != read.fields.end(); };
  if (field.empty() && has("red") && has("green") && has("blue")) {
    if (std::string fault = Color(data, layout, head, read); !fault.empty()) return fault;
  } else {
    auto chosen = head.fields().begin();
    if (!field.empty()) {
      chosen = std::ranges::find_if(head.fields(), [&](const auto& one) { return one.name() == field; });
      if (chosen == head.fields().end()) return "The grid has no field \"" + std::string(field) + "\".";
    }
    const auto values = CellValues::Of(data, layout, FieldOf(*chosen));
    if (!values) return values.fault();
    read.field = chosen->name();
    Paint(*values, palette.value_or(IsByte(values->type()) ? GridPalette::kMap : GridPalette::kRaw), read);
  }
  picture = std::move(read);
  return {};
}

}  // namespace hgros::viewer
