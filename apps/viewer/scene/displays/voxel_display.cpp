#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "viewer/data/grid/cell_text.hpp"
#include "viewer/data/value_range.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/newest_message.hpp"
#include "viewer/scene/displays/placed_display.hpp"
#include "viewer/scene/layers/voxel_cubes.hpp"
#include "viewer/scene/settings/color_map_settings.hpp"

namespace hgros::viewer {
namespace {

using VoxelGrid = Bulk<foxglove::VoxelGrid>;

constexpr std::size_t kPointsOfACube = 4;  ///< Drawing a cube takes about as long as drawing this many points.

struct VoxelOptions {
  std::string field;
  float threshold = 0;
};

struct ReadVoxelGrid {
  VoxelPicture picture;
  ValueRange values;
  Eigen::AlignedBox3d box;  ///< Bounding box of the occupied cells, relative to the corner.
};

std::string ReadVoxels(const VoxelGrid& grid, const VoxelOptions& options, ReadVoxelGrid& read) {
  if (std::string fault = ReadVoxels(grid, options.field, static_cast<double>(options.threshold), read.picture);
      !fault.empty()) {
    return fault;
  }
  for (const std::size_t count : read.picture.counts) {
    if (count > VoxelCubes::kMostInARow) {
      return "The voxel grid has more than " + std::to_string(VoxelCubes::kMostInARow) + " cells in a row.";
    }
  }
  const Eigen::Vector3d& size = read.picture.cell_size;
  std::vector<float> values;
  values.reserve(read.picture.cubes.size());
  for (const VoxelCube& cube : read.picture.cubes) {
    const Eigen::Vector3d least = size.cwiseProduct(Eigen::Vector3d(cube.cell[0], cube.cell[1], cube.cell[2]));
    read.box.extend(least);
    read.box.extend(least + size);
    values.push_back(cube.value);
  }
  (void)read.values.Cover(values);
  return {};
}

/// The occupied voxels of the newest grid of a channel.
class VoxelDisplay : public PlacedDisplay {
 public:
  explicit VoxelDisplay(const DisplayInputs& inputs) : newest_(inputs, VoxelOptions(), ReadVoxels) {}

  [[nodiscard]] std::vector<Setting> Settings() override {
    const auto mapped = [this] { return color_by_ != static_cast<int>(VoxelStyle::ColorBy::kFlat); };
    const auto [map, automatic, lowest, highest] = ColorMapSettings(
        {&style_.map, &auto_range_, &lo_, &hi_},
        "The colors go from the lowest to the highest height, or value without the outer 2 % at each end.", mapped,
        {"color", {"height", "value"}});
    return {
        {"color", "What the color shows.", Setting::Choice{&color_by_, {"flat", "height", "value"}}},
        {"flat",
         "The color of all voxels.",
         Setting::Color{&style_.flat},
         [mapped] { return !mapped(); },
         {{"color", {"flat"}}}},
        map,
        automatic,
        lowest,
        highest,
        {"field", "The field that decides which voxels are occupied; empty: the first field.", Setting::Text{&field_}},
        {"threshold", "A voxel with a value above it is occupied.", Setting::Number{&threshold_, -1e6F, 1e6F, ""}},
        {"alpha", "Opacity: 0 is invisible, 1 is opaque.", Setting::Number{&style_.alpha, 0, 1, ""}},
    };
  }
  [[nodiscard]] std::size_t settled_points() const override { return blended() ? 0 : kPointsOfACube * cubes_.size(); }
  [[nodiscard]] std::size_t gpu_bytes() const override { return cubes_.gpu_bytes(); }
  [[nodiscard]] std::optional<ColorLegend> Legend() const override {
    const VoxelStyle style = Style();
    if (empty() || style.color_by == VoxelStyle::ColorBy::kFlat) return std::nullopt;
    const bool value = style.color_by == VoxelStyle::ColorBy::kValue;
    return ColorLegend{value ? read_.picture.field : "height in m", static_cast<ColorMap>(style.map), style.lo,
                       style.hi};
  }
  // The picked point is on a face between two cells. The occupied one is meant.
  [[nodiscard]] std::string ValueAt(const Eigen::Vector3d& at, double radius_m) const override {
    const auto from_corner = FromCorner(at);
    if (!from_corner || !shown_) return {};
    const foxglove::VoxelGrid& head = shown_->head();
    const VoxelPicture& picture = read_.picture;
    CellValues::Layout layout{picture.counts[0], picture.counts[1], picture.counts[2]};
    layout.cell_stride = head.cell_stride();
    layout.row_stride = head.row_stride();
    layout.slice_stride = head.slice_stride();
    const auto field = std::ranges::find(head.fields(), picture.field, &foxglove::PackedElementField::name);
    if (field == head.fields().end()) return {};
    const auto values =
        CellValues::Of(shown_->bytes(), layout, {field->name(), field->offset(), static_cast<int>(field->type())});
    if (!values) return {};
    for (int step = -1; step < 6; ++step) {
      Eigen::Vector3d inside = from_corner->cwiseQuotient(picture.cell_size);
      if (step >= 0) {
        const double cell = picture.cell_size[step / 2];
        inside[step / 2] += (step % 2 == 0 ? -1 : 1) * std::min(radius_m, 0.5 * cell) / cell;
      }
      const Eigen::Vector3d cell = inside.array().floor();
      std::array<std::size_t, 3> index{};
      bool there = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double part = cell[static_cast<Eigen::Index>(axis)];
        there = there && part >= 0 && part < static_cast<double>(picture.counts[axis]);
        if (there) index[axis] = static_cast<std::size_t>(part);
      }
      if (!there || !(values->At(index[0], index[1], index[2]) > static_cast<double>(threshold_))) continue;
      return CellText(shown_->bytes(), layout, head.fields(), picture.field, index);
    }
    return {};
  }

 protected:
  [[nodiscard]] std::optional<std::string> TakeArrived() override { return Show(newest_.Take()); }
  [[nodiscard]] std::optional<std::string> TakeAgain() override { return Show(newest_.TakeAgain()); }
  void TakeSetting(const std::string& name) override {
    if (name == "field" || name == "threshold") newest_.SetOptions({field_, threshold_});
  }
  void Forget() override {
    newest_.Clear();
    shown_.reset();
    read_ = {};
    cubes_.Set({});
  }
  [[nodiscard]] bool empty() const override { return cubes_.size() == 0; }
  [[nodiscard]] bool blended() const override { return style_.alpha < 1; }
  [[nodiscard]] const std::string& frame() const override { return read_.picture.frame; }
  [[nodiscard]] const Eigen::Isometry3d& T_frame_corner() const override { return read_.picture.T_frame_corner; }
  [[nodiscard]] Eigen::AlignedBox3d box() const override { return read_.box; }
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const Slice& slice) override {
    cubes_.Draw(context, T_fixed_corner, Style(), slice, blended());
  }
  void Describe(std::vector<std::string>& lines) const override {
    const VoxelPicture& picture = read_.picture;
    lines.push_back(std::to_string(picture.occupied) + " of " + std::to_string(picture.counts[0]) + " x " +
                    std::to_string(picture.counts[1]) + " x " + std::to_string(picture.counts[2]) +
                    " voxels are occupied, " + std::to_string(cubes_.size()) + " of them are visible.");
    lines.push_back("The value is " + picture.field + ".");
    ListFields(picture.fields, lines);
  }
  [[nodiscard]] std::uint64_t received() const override { return newest_.received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return newest_.dropped(); }

 private:
  using Newest = NewestMessage<VoxelGrid, VoxelOptions, ReadVoxelGrid>;

  [[nodiscard]] VoxelStyle Style() const {
    VoxelStyle style = style_;
    style.color_by = static_cast<VoxelStyle::ColorBy>(color_by_);
    if (!auto_range_) {
      style.lo = static_cast<double>(lo_);
      style.hi = static_cast<double>(hi_);
    } else if (style.color_by == VoxelStyle::ColorBy::kValue) {
      style.lo = static_cast<double>(read_.values.lo());
      style.hi = static_cast<double>(read_.values.hi());
    } else {
      const Eigen::AlignedBox3d bounds = Bounds();
      style.lo = bounds.min().z();
      style.hi = bounds.max().z();
    }
    return style;
  }

  [[nodiscard]] std::optional<std::string> Show(std::optional<Newest::Read> read) {
    if (!read) return std::nullopt;
    if (!read->fault.empty()) return std::move(read->fault);
    shown_ = std::move(read->message);
    read_ = std::move(read->shown);
    cubes_.Set(read_.picture);
    read_.picture.cubes = std::vector<VoxelCube>();  // The message is kept, so they can be made again.
    return std::string();
  }

  std::shared_ptr<const VoxelGrid> shown_;
  ReadVoxelGrid read_;  ///< Without the cubes.
  VoxelCubes cubes_;

  VoxelStyle style_{.flat = {0.75F, 0.78F, 0.82F}};
  int color_by_ = static_cast<int>(VoxelStyle::ColorBy::kHeight);
  bool auto_range_ = true;
  float lo_ = 0;
  float hi_ = 10;
  std::string field_;
  float threshold_ = 0;

  Newest newest_;
};

}  // namespace

DisplayType VoxelDisplayType() {
  return {"Voxels", {"foxglove.VoxelGrid"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<VoxelDisplay>(inputs);
          }};
}

}  // namespace hgros::viewer
