#include <cmath>
#include <memory>
#include <utility>

#include "viewer/data/grid/cell_text.hpp"
#include "viewer/data/grid/grid_reader.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/newest_message.hpp"
#include "viewer/scene/displays/placed_display.hpp"
#include "viewer/scene/layers/picture_tiles.hpp"

namespace hgros::viewer {
namespace {

using Grid = Bulk<foxglove::Grid>;

struct GridOptions {
  std::string field;
  std::optional<GridPalette> palette;
};

struct ReadPicture {
  GridPicture picture;       ///< The colors are premultiplied by alpha.
  bool see_through = false;  ///< Somewhere.
};

std::string ReadCells(const Grid& grid, const GridOptions& options, ReadPicture& read) {
  std::string fault = ReadGrid(grid, options.field, options.palette, read.picture);
  for (Rgba& pixel : read.picture.pixels) {
    const unsigned alpha = AlphaOf(pixel);
    if (alpha == 255) continue;
    read.see_through = true;
    const auto times = [alpha](unsigned channel) { return (channel & 255U) * alpha / 255; };
    pixel = MakeRgba(times(pixel), times(pixel >> 8U), times(pixel >> 16U), alpha);
  }
  return fault;
}

/// The newest grid of a channel, as a picture on the ground.
class GridDisplay : public PlacedDisplay {
 public:
  explicit GridDisplay(const DisplayInputs& inputs) : newest_(inputs, GridOptions(), ReadCells) {}

  [[nodiscard]] std::vector<Setting> Settings() override {
    std::vector<std::string> palettes = {"as it suits"};
    palettes.insert(palettes.end(), kGridPaletteNames.begin(), kGridPaletteNames.end());
    return {
        {"palette",
         "How values become colors: map (0 free to 100 occupied), costmap (1 to 98 from blue to red), raw (black at "
         "the lowest value, white at the highest).",
         Setting::Choice{&palette_, palettes}},
        {"field", "The field of the cells that is shown; empty: their color, or else the first field.",
         Setting::Text{&field_}},
        {"alpha", "Opacity: 0 is invisible, 1 is opaque.", Setting::Number{&alpha_, 0, 1, ""}},
    };
  }
  [[nodiscard]] std::size_t gpu_bytes() const override { return tiles_.gpu_bytes(); }
  [[nodiscard]] bool moves_back() const override { return true; }
  [[nodiscard]] std::string ValueAt(const Eigen::Vector3d& at, double radius_m) const override {
    const auto from_corner = FromCorner(at);
    if (!from_corner || !shown_ || std::abs(from_corner->z()) > radius_m) return {};
    const double column = std::floor(from_corner->x() / grid_.cell_size.x());
    const double row = std::floor(from_corner->y() / grid_.cell_size.y());
    if (!(column >= 0 && row >= 0 && column < static_cast<double>(grid_.columns) &&
          row < static_cast<double>(grid_.rows))) {
      return {};
    }
    const foxglove::Grid& head = shown_->head();
    CellValues::Layout layout{grid_.columns, grid_.rows};
    layout.cell_stride = head.cell_stride();
    layout.row_stride = head.row_stride();
    return CellText(shown_->bytes(), layout, head.fields(), grid_.colored ? "" : grid_.field,
                    {static_cast<std::size_t>(column), static_cast<std::size_t>(row), 0});
  }

 protected:
  [[nodiscard]] std::optional<std::string> TakeArrived() override { return Show(newest_.Take()); }
  [[nodiscard]] std::optional<std::string> TakeAgain() override { return Show(newest_.TakeAgain()); }
  void TakeSetting(const std::string& name) override {
    if (name == "alpha") return;
    newest_.SetOptions({field_, palette_ == 0 ? std::nullopt : std::optional(static_cast<GridPalette>(palette_ - 1))});
  }
  void Forget() override {
    newest_.Clear();
    shown_.reset();
    grid_ = {};
    tiles_.Set({}, 0, 0);
  }
  [[nodiscard]] bool empty() const override { return grid_.columns * grid_.rows == 0; }
  [[nodiscard]] bool blended() const override { return see_through_ || alpha_ < 1; }
  [[nodiscard]] const std::string& frame() const override { return grid_.frame; }
  [[nodiscard]] const Eigen::Isometry3d& T_frame_corner() const override { return grid_.T_frame_corner; }
  [[nodiscard]] Eigen::AlignedBox3d box() const override {
    const Eigen::Vector3d far(grid_.cell_size.x() * static_cast<double>(grid_.columns),
                              grid_.cell_size.y() * static_cast<double>(grid_.rows), 0);
    return {Eigen::Vector3d::Zero(), far};
  }
  void Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const Slice& slice) override {
    if (slice.index == 0) tiles_.Draw(context, T_fixed_corner, grid_.cell_size, alpha_, blended());
  }
  void Describe(std::vector<std::string>& lines) const override {
    lines.push_back(std::to_string(grid_.columns) + " x " + std::to_string(grid_.rows) + " cells in " + grid_.frame);
    lines.push_back(grid_.colored ? "The cells have their own colors." : "The value is " + grid_.field + ".");
    ListFields(grid_.fields, lines);
  }
  [[nodiscard]] std::uint64_t received() const override { return newest_.received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return newest_.dropped(); }

 private:
  using Newest = NewestMessage<Grid, GridOptions, ReadPicture>;

  [[nodiscard]] std::optional<std::string> Show(std::optional<Newest::Read> read) {
    if (!read) return std::nullopt;
    if (!read->fault.empty()) return std::move(read->fault);
    shown_ = std::move(read->message);
    grid_ = std::move(read->shown.picture);
    see_through_ = read->shown.see_through;
    tiles_.Set(grid_.pixels, grid_.columns, grid_.rows);
    grid_.pixels = std::vector<Rgba>();  // The message is kept, so they can be made again.
    return std::string();
  }

  std::shared_ptr<const Grid> shown_;
  GridPicture grid_;  ///< Without its pixels.
  PictureTiles tiles_;
  bool see_through_ = false;

  int palette_ = 0;
  std::string field_;
  float alpha_ = 1;

  Newest newest_;
};

}  // namespace

DisplayType GridDisplayType() {
  return {"Grid", {"foxglove.Grid"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<GridDisplay>(inputs);
          }};
}

}  // namespace hgros::viewer
