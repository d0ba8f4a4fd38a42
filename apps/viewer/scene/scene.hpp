#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "viewer/scene/display.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/gl/picture.hpp"
#include "viewer/scene/layers/point_programs.hpp"

namespace hgros::viewer {

/// All displays and the picture that they make.
///
/// The settled layer is kept between frames: while the camera does not move, only new data costs time. While the camera
/// moves, one slice of everything is drawn, as much as fits into a frame. When the camera rests, each frame adds a
/// slice until the picture is complete. The size of a slice is measured. Thread: the one whose GL context is current.
class Scene {
 public:
  struct Entry {
    std::string name;
    std::string channel;
    const DisplayType* type = nullptr;
    std::size_t number = 0;  ///< The least that no other display of the type had when this one was added.
    std::unique_ptr<Display> display;
    bool visible = true;
    std::uint64_t dropped_before = 0;         ///< CountDropped.
    std::uint64_t unreadable = 0;             ///< Messages of the channel that do not match their publisher's type.
    bool still_unreadable = false;            ///< More unreadable messages are arriving.
    std::vector<std::string> without_effect;  ///< Settings that were given but have no effect (WhyWithoutEffect).
    std::string mismatch;  ///< A sentence, if the channel carries a type that the display does not show.
  };

  Entry& Add(const DisplayType& type, const DisplayInputs& inputs);
  void Remove(std::size_t index);
  /// Exchanges the entry with the one above it.
  void MoveUp(std::size_t index);
  void SetVisible(std::size_t index, bool visible);
  [[nodiscard]] std::vector<Entry>& entries() noexcept { return entries_; }
  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }

  /// Takes what has arrived.
  void Update(const UpdateContext& context);
  /// Display::ApplySettings of all displays.
  void ApplySettings(const UpdateContext& context);
  /// Display::LookBack of all displays.
  void LookBack(double newest_s, double back_s);
  /// Time of the oldest data of all visible displays.
  [[nodiscard]] double oldest_s() const;
  /// Before this time, some of them cannot show the true state.
  [[nodiscard]] double truthful_since_s() const;
  /// Whether something has changed since the last Draw.
  [[nodiscard]] bool pending() const noexcept { return pending_ != Change::kNothing; }
  /// Makes the next Draw draw the whole settled layer again.
  void Redraw() noexcept { pending_ = Change::kRedraw; }
  /// `scale`: screen pixels per pixel of a setting.
  void Draw(const ViewMatrices& view, float scale);
  /// Whether the settled layer is incomplete: another Draw with the same view adds a slice.
  [[nodiscard]] bool unfinished() const noexcept { return next_slice_ < slices_; }
  [[nodiscard]] const Picture& picture() const noexcept { return picture_; }

  /// The nearest depth within a radius around the pixel (x, y), counted from the upper left corner. Sets x and y to the
  /// pixel with that depth. 1 if there is nothing. Draws first if the view has changed since the last Draw.
  [[nodiscard]] float NearestDepth(const ViewMatrices& view, float scale, int& x, int& y, int radius);
  /// The display that is visible at a pixel, counted from the upper left corner, with that depth. Null if there is
  /// none. Draws each display again, alone. Sets `depth` to the display's own: in the picture, some are drawn farther
  /// away, so that others in the same plane cover them.
  [[nodiscard]] const Entry* EntryAt(const ViewMatrices& view, float scale, int x, int y, float& depth) {
    return FindAt(view, scale, x, y, depth, false);
  }
  /// Sets `depth` as EntryAt does. Draws only the displays that can change it.
  void CorrectDepth(const ViewMatrices& view, float scale, int x, int y, float& depth) {
    (void)FindAt(view, scale, x, y, depth, true);
  }
  /// Starts the counter of dropped().
  void CountDropped();
  /// Messages that the current displays have dropped since CountDropped.
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
  /// EntryAt; with `only_moved_back`, among those that move back.
  [[nodiscard]] const Entry* FindAt(const ViewMatrices& view, float scale, int x, int y, float& depth,
                                    bool only_moved_back);
  /// The depth of one display alone, at a pixel. Changes what is bound.
  [[nodiscard]] static float DepthAlone(Display& display, const DrawContext& context, Picture& probe, int x, int y);
  void DrawSlice(const DrawContext& context);
  void DrawMoving(const DrawContext& context);
  void DrawBlended(const DrawContext& context);
  void Measure(std::size_t drawn, std::chrono::steady_clock::time_point begin);
  /// Number of points that can be drawn in that time, as measured.
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
  double points_per_ms_ = 5000;  ///< Measured; a guess before the first measurement.
};

}  // namespace hgros::viewer
