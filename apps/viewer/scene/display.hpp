#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "viewer/data/color_map.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/data/image/image_picture.hpp"
#include "viewer/data/shapes/scene_shapes.hpp"
#include "viewer/scene/gl/slice.hpp"
#include "viewer/scene/layers/point_programs.hpp"
#include "viewer/scene/settings/setting.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// The effect of an update on the picture. A greater value includes the smaller ones.
enum class Change : std::uint8_t {
  kNothing,
  kMoving,    ///< The output of DrawMoving or DrawBlended has changed.
  kAppended,  ///< DrawNew has something for the settled layer.
  kRedraw,    ///< The settled layer must be drawn again.
};

/// The inputs of a display's constructor. The session must outlive the displays. Any thread may call `wake`; it causes
/// an Update.
struct DisplayInputs {
  Session& session;
  std::string channel;
  std::function<void()> wake;
  std::size_t number = 0;  ///< Differs from that of all other displays of the type. The scene sets it.
};

/// How long data waits for its transform before that is reported as an error.
inline constexpr double kLongestWaitS = 2;

struct UpdateContext {
  FixedFrame& frame;
  double now_s;             ///< On a steady clock.
  bool frame_changed;       ///< The fixed frame has changed: everything placed in the old one is invalid.
  bool transforms_changed;  ///< Since the last update.
};

struct DrawContext {
  const ViewMatrices& view;
  PointPrograms& points;
  float scale;                     ///< Screen pixels per pixel of a setting.
  std::size_t moving_thinned = 1;  ///< Draw every n-th point of the moving layer.
  bool marks_depth = false;        ///< Transparent displays write their depth, too, so that they can be picked.
  bool true_depth = false;         ///< Pictures do not move back to let others in the same plane cover them.
};

/// A text at a place of the scene.
struct Label {
  Eigen::Vector3d at;
  std::string text;
  Rgba color = MakeRgba(235, 238, 242);
  float height = 0;  ///< In pixels or meters; 0: the usual height.
  bool in_meters = false;
};

/// The meaning of the colors of a display.
struct ColorLegend {
  std::string name;  ///< Of what the color shows.
  ColorMap map = ColorMap::kRainbow;
  double lowest = 0;  ///< The value of the first color.
  double highest = 1;
};

/// An image that is shown in its own panel.
struct ShownImage {
  const ImagePicture* picture;  ///< Without its pixels. Valid until the next Update.
  unsigned texture;             ///< Its name in GL.
};

/// Shows the messages of one channel, or something that the viewer itself knows. Messages arrive on threads of the
/// session and wait in an Inbox. The drawing thread calls all methods below, with its GL context current.
///
/// There are two layers. The settled layer is opaque and is kept from frame to frame. DrawNew adds to it, so only new
/// data costs time. After Change::kRedraw, or when the camera moves, DrawSettled is called for all slices, over several
/// frames if there is much to draw. The moving layer is drawn over it in every frame. Transparent parts come last.
class Display {
 public:
  Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  virtual ~Display() = default;

  /// Takes what has arrived.
  [[nodiscard]] virtual Change Update(const UpdateContext& context) = 0;
  virtual void DrawNew(const DrawContext& /*context*/) {}
  virtual void DrawSettled(const DrawContext& /*context*/, const Slice& /*slice*/) {}
  virtual void DrawMoving(const DrawContext& /*context*/) {}
  /// Called in every frame after everything opaque, if blends(). It must not change the depth unless the context has
  /// marks_depth.
  virtual void DrawBlended(const DrawContext& /*context*/) {}
  /// It is drawn farther away than it is, unless the context has true_depth.
  [[nodiscard]] virtual bool moves_back() const { return false; }
  /// A part of it is transparent.
  [[nodiscard]] virtual bool blends() const { return false; }
  /// Shows its state `back_s` before `newest_s`, the time of the last Update, as far as that is kept. 0: shows
  /// everything.
  [[nodiscard]] virtual Change LookBack(double /*newest_s*/, double /*back_s*/) { return Change::kNothing; }
  /// Time of the oldest data that LookBack can show, on the clock of UpdateContext. Infinity if there is none.
  [[nodiscard]] virtual double oldest_s() const { return std::numeric_limits<double>::infinity(); }
  /// LookBack cannot show the true state before this time, on the same clock. Minus infinity: it always can.
  [[nodiscard]] virtual double truthful_since_s() const { return -std::numeric_limits<double>::infinity(); }
  /// Applies settings that were changed while the picture is paused to what is shown.
  [[nodiscard]] virtual Change ApplySettings(const UpdateContext& /*context*/) { return Change::kNothing; }
  /// Forgets all data that it has kept.
  virtual void Clear() {}

  [[nodiscard]] virtual std::vector<Setting> Settings() { return {}; }
  /// Call it when the setting `name` has changed.
  virtual void OnSetting(const std::string& /*name*/) {}
  /// Its status as sentences; errors come first.
  [[nodiscard]] virtual std::vector<std::string> Status() const { return {}; }
  [[nodiscard]] virtual bool HasFault() const { return false; }
  /// Which transform it waits for, as a sentence. After kLongestWaitS without that transform, this becomes an error of
  /// Status. Empty: it waits for none.
  [[nodiscard]] virtual std::string WaitsFor() const { return {}; }
  [[nodiscard]] virtual std::vector<Label> Labels() const { return {}; }
  /// None while the colors show no values.
  [[nodiscard]] virtual std::optional<ColorLegend> Legend() const { return std::nullopt; }
  [[nodiscard]] virtual std::optional<ShownImage> Image() const { return std::nullopt; }
  /// The value of a pixel of its image as text. Reads a color back from the GPU.
  [[nodiscard]] virtual std::string PixelText(std::size_t /*x*/, std::size_t /*y*/) const { return {}; }
  /// Number of points that DrawSettled draws. It decides the number of slices.
  [[nodiscard]] virtual std::size_t settled_points() const { return 0; }
  /// Number of points that DrawMoving draws without thinning.
  [[nodiscard]] virtual std::size_t moving_points() const { return 0; }
  [[nodiscard]] virtual std::size_t points() const { return 0; }
  [[nodiscard]] virtual std::size_t gpu_bytes() const { return 0; }
  [[nodiscard]] virtual Eigen::AlignedBox3d Bounds() const { return {}; }
  /// The frame of the data that is shown. Empty: none, or several.
  [[nodiscard]] virtual std::string data_frame() const { return {}; }
  /// Describes what is shown at a point of the fixed frame, or within `radius_m` around it.
  [[nodiscard]] virtual std::string ValueAt(const Eigen::Vector3d& /*at*/, double /*radius_m*/) const { return {}; }
  /// Messages that arrived, including those that were dropped later.
  [[nodiscard]] virtual std::uint64_t received() const { return 0; }
  /// Messages that were dropped because they arrived too fast or while the picture was paused.
  [[nodiscard]] virtual std::uint64_t dropped() const { return 0; }
  /// The next time when it changes without a message, on the clock of UpdateContext.
  [[nodiscard]] virtual double next_change_s() const { return std::numeric_limits<double>::infinity(); }
};

}  // namespace hgros::viewer
