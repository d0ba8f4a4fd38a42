#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "viewer/scene/display.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/picture.hpp"
#include "viewer/scene/point_programs.hpp"

namespace hgros::viewer {

/// All displays and the picture that they make.
///
/// The settled layer is kept between frames: while the camera stands still, a frame costs what is new. When the camera
/// moves, one slice of everything is drawn, as much as fits into a frame; when it rests, a slice more in each frame
/// until the picture is whole. How much that is, is measured.
/// Thread: the one whose GL context is current.
class Scene {
 public:
  struct Entry {
    std::string name;
    std::string channel;
    const DisplayType* type = nullptr;
    std::unique_ptr<Display> display;
    bool visible = true;
    std::uint64_t dropped_before = 0;         ///< CountDropped.
    std::uint64_t unreadable = 0;             ///< Messages of the channel that are not what their publisher says.
    bool still_unreadable = false;            ///< And more come.
    std::vector<std::string> without_effect;  ///< Settings that were given and need others; WhyWithoutEffect.
    std::string mismatch;                     ///< The channel carries what the display does not show: a sentence.
  };

  Entry& Add(const DisplayType& type, const DisplayInputs& inputs);
  void Remove(std::size_t index);
  /// Exchanges two neighbours.
  void MoveUp(std::size_t index);
  void SetVisible(std::size_t index, bool visible);
  [[nodiscard]] std::vector<Entry>& entries() noexcept { return entries_; }
  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }

  /// Takes in what has arrived.
  void Update(const UpdateContext& context);
  /// As Display::ApplySettings, of all.
  void ApplySettings(const UpdateContext& context);
  /// As Display::LookBack, of all.
  void LookBack(double newest_s, double back_s);
  /// Of those that are visible, the oldest there is.
  [[nodiscard]] double oldest_s() const;
  /// Before that some of them would show what was not there.
  [[nodiscard]] double truthful_since_s() const;
  /// Whether something has changed since the last Draw.
  [[nodiscard]] bool pending() const noexcept { return pending_ != Change::kNothing; }
  /// The whole settled layer is out of date.
  void Redraw() noexcept { pending_ = Change::kRedraw; }
  /// `scale`: pixels of the screen to a pixel as people set it.
  void Draw(const ViewMatrices& view, float scale);
  /// The settled layer still lacks slices: another Draw with the same view adds one.
  [[nodiscard]] bool unfinished() const noexcept { return next_slice_ < slices_; }
  [[nodiscard]] const Picture& picture() const noexcept { return picture_; }

  /// The nearest depth of what is seen within some pixels around one, which becomes the one that is meant; counted from
  /// the upper left corner. 1 where there is nothing. Draws first if the last Draw was with another view.
  [[nodiscard]] float NearestDepth(const ViewMatrices& view, float scale, int& x, int& y, int radius);
  /// What is seen at a pixel, counted from the upper left corner, if its depth is what is there; null if it is none of
  /// the displays. Draws each that may be it once more, alone. `at` is the pixel's point in the fixed frame.
  [[nodiscard]] const Entry* EntryAt(const ViewMatrices& view, float scale, int x, int y, float depth,
                                     const Eigen::Vector3d& at);
  /// From here on dropped() counts.
  void CountDropped();
  /// Messages that the displays that are there could not take since CountDropped.
  [[nodiscard]] std::uint64_t dropped() const;

  [[nodiscard]] std::size_t points() const;
  [[nodiscard]] std::size_t gpu_bytes() const;
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const;
  [[nodiscard]] double next_change_s() const;
  [[nodiscard]] std::vector<Label> Labels() const;

 private:
  [[nodiscard]] bool Moved(const ViewMatrices& view) const {
    return view.clip_from_eye != drawn_clip_ || view.eye != drawn_eye_;
  }
  void DrawSlice(const DrawContext& context);
  void DrawMoving(const DrawContext& context);
  void DrawBlended(const DrawContext& context);
  void Measure(std::size_t drawn, std::chrono::steady_clock::time_point begin);
  /// So many points are drawn in that time, as far as is known.
  [[nodiscard]] std::size_t Affordable(double ms) const;

  std::vector<Entry> entries_;
  PointPrograms points_;
  Picture settled_;
  Picture picture_;
  Change pending_ = Change::kRedraw;
  Eigen::Matrix4f drawn_clip_ = Eigen::Matrix4f::Zero();
  Eigen::Vector3d drawn_eye_ = Eigen::Vector3d::Zero();
  std::size_t slices_ = 1;
  std::size_t next_slice_ = 0;
  double points_per_ms_ = 5000;  ///< As measured; a guess until then.
};

}  // namespace hgros::viewer
