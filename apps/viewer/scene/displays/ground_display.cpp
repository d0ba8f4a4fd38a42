#include <array>
#include <cmath>
#include <utility>

#include "viewer/scene/display_types.hpp"
#include "viewer/scene/layers/segments.hpp"

namespace hgros::viewer {
namespace {

std::uint32_t Packed(const std::array<float, 3>& color, float share) {
  std::uint32_t packed = 0xFF000000U;
  for (std::size_t i = 0; i < 3; ++i)
    packed |= static_cast<std::uint32_t>(std::lround(color[i] * share * 255)) << (8 * i);
  return packed;
}

/// A square pattern in the plane z = 0 of the fixed frame, and its x and y axes.
class GroundDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& /*context*/) override {
    if (!std::exchange(setting_changed_, false)) return Change::kNothing;
    const float half = 0.5F * std::floor(cells_) * cell_meters_;
    const auto lines = static_cast<int>(cells_) + 1;
    std::vector<Segments::Segment> segments;
    for (int i = 0; i < lines; ++i) {
      const float at = -half + static_cast<float>(i) * cell_meters_;
      const std::uint32_t color = Packed(color_, i % 10 == 0 ? 1.0F : 0.75F);
      segments.push_back({{at, -half, 0}, {at, half, 0}, color});
      segments.push_back({{-half, at, 0}, {half, at, 0}, color});
    }
    if (axes_) {
      segments.push_back({{0, 0, 0}, {cell_meters_, 0, 0}, 0xFF3A3AE0U});
      segments.push_back({{0, 0, 0}, {0, cell_meters_, 0}, 0xFF3AC03AU});
      segments.push_back({{0, 0, 0}, {0, 0, cell_meters_}, 0xFFE07A3AU});
    }
    segments_.Set(segments);
    return Change::kRedraw;
  }

  [[nodiscard]] Change ApplySettings(const UpdateContext& context) override { return Update(context); }

  void DrawSettled(const DrawContext& context, const Slice& slice) override {
    if (slice.index == 0) segments_.Draw(context.view, RigidTransform(), context.scale);
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    return {
        {"cell", "The edge of a square.", Setting::Number{&cell_meters_, 0.001F, 10'000, "m"}},
        {"cells", "Number of squares in a row.", Setting::Number{&cells_, 1, 1000, ""}},
        {"color", "The color of the lines.", Setting::Color{&color_}},
        {"axes", "The axes of the fixed frame.", Setting::Switch{&axes_}},
    };
  }
  void OnSetting(const std::string& /*name*/) override { setting_changed_ = true; }

 private:
  Segments segments_;
  bool setting_changed_ = true;
  float cell_meters_ = 1;
  float cells_ = 20;
  std::array<float, 3> color_ = {0.27F, 0.29F, 0.32F};
  bool axes_ = true;
};

}  // namespace

DisplayType GroundDisplayType() {
  return {"Ground", {}, [](const DisplayInputs& /*inputs*/) -> std::unique_ptr<Display> {
            return std::make_unique<GroundDisplay>();
          }};
}

}  // namespace hgros::viewer
