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
#include "viewer/data/fixed_frame.hpp"
#include "viewer/data/image_picture.hpp"
#include "viewer/data/scene_shapes.hpp"
#include "viewer/scene/point_programs.hpp"
#include "viewer/scene/setting.hpp"
#include "viewer/scene/slice.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// What an update means for the picture; the greater value includes the smaller ones.
enum class Change : std::uint8_t {
  kNothing,
  kMoving,    ///< What DrawMoving or DrawBlended draws.
  kAppended,  ///< DrawNew has something for the settled layer.
  kRedraw,    ///< The settled layer has to be drawn anew.
};

/// What displays are made from. The session outlives them; `wake` may be called by any thread, and brings an Update.
struct DisplayInputs {
  Session& session;
  std::string channel;
  std::function<void()> wake;
};

struct UpdateContext {
  FixedFrame& frame;
  double now_s;             ///< On a steady clock.
  bool frame_changed;       ///< The fixed frame is another one: what was placed in the old one is void.
  bool transforms_changed;  ///< Since the last update.
};

struct DrawContext {
  const ViewMatrices& view;
  PointPrograms& points;
  float scale;                     ///< Pixels of the screen to a pixel as settings mean it.
  std::size_t moving_thinned = 1;  ///< Of the points that move every so-manieth is drawn.
  bool marks_depth = false;        ///< What can be seen through leaves its depth as well, so that it can be picked.
};

/// Words at a place of the scene.
struct Label {
  Eigen::Vector3d at;
  std::string text;
  Rgba color = MakeRgba(235, 238, 242);
  float height = 0;  ///< In pixels or metres; 0: as it is usual.
  bool in_metres = false;
};

/// An image that has a panel of its own.
struct ShownImage {
  const ImagePicture* picture;  ///< Until the next Update.
  unsigned texture;             ///< GL's name of it.
};

/// Something that is shown: messages of one channel, or what the viewer itself knows. Messages arrive on threads of the
/// session and wait in an Inbox; everything below is called by the thread that draws, with its GL context current.
///
/// There are two layers. The settled one is kept from frame to frame: what DrawNew adds costs only itself, and after
/// Change::kRedraw, or when the camera moves, DrawSettled is called for all slices, over several frames if there is
/// much. It is opaque. The moving one is drawn over it in every frame, and what can be seen through last.
class Display {
 public:
  Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  virtual ~Display() = default;

  /// Takes in what has arrived.
  [[nodiscard]] virtual Change Update(const UpdateContext& context) = 0;
  virtual void DrawNew(const DrawContext& /*context*/) {}
  virtual void DrawSettled(const DrawContext& /*context*/, const Slice& /*slice*/) {}
  virtual void DrawMoving(const DrawContext& /*context*/) {}
  /// In every frame, too, after everything opaque, whose depth it must leave as it is unless it marks_depth; if
  /// blends().
  virtual void DrawBlended(const DrawContext& /*context*/) {}
  /// Something of it can be seen through.
  [[nodiscard]] virtual bool blends() const { return false; }
  /// Shows what it had `back_s` before the newest that Update took in at `newest_s`, as far as that is kept; 0: all.
  [[nodiscard]] virtual Change LookBack(double /*newest_s*/, double /*back_s*/) { return Change::kNothing; }
  /// From when the oldest is that LookBack can show, on the clock of UpdateContext; infinity: there is nothing.
  [[nodiscard]] virtual double oldest_s() const { return std::numeric_limits<double>::infinity(); }
  /// Before that LookBack cannot show what was there, on the same clock; minus infinity: it always can.
  [[nodiscard]] virtual double truthful_since_s() const { return -std::numeric_limits<double>::infinity(); }
  /// Settings that were changed while nothing is taken in apply to what is shown.
  [[nodiscard]] virtual Change ApplySettings(const UpdateContext& /*context*/) { return Change::kNothing; }
  /// Forgets what it has kept.
  virtual void Clear() {}

  [[nodiscard]] virtual std::vector<Setting> Settings() { return {}; }
  /// A setting has changed, and `name` is which one.
  virtual void OnSetting(const std::string& /*name*/) {}
  /// What there is to say: first what is wrong, in sentences.
  [[nodiscard]] virtual std::vector<std::string> Status() const { return {}; }
  [[nodiscard]] virtual bool HasFault() const { return false; }
  [[nodiscard]] virtual std::vector<Label> Labels() const { return {}; }
  [[nodiscard]] virtual std::optional<ShownImage> Image() const { return std::nullopt; }
  /// How much DrawSettled draws, in points; decides into how many slices it is cut.
  [[nodiscard]] virtual std::size_t settled_points() const { return 0; }
  /// How many points DrawMoving draws, unless they are thinned.
  [[nodiscard]] virtual std::size_t moving_points() const { return 0; }
  [[nodiscard]] virtual std::size_t points() const { return 0; }
  [[nodiscard]] virtual std::size_t gpu_bytes() const { return 0; }
  [[nodiscard]] virtual Eigen::AlignedBox3d Bounds() const { return {}; }
  /// The frame that what is shown came in; empty: none, or several.
  [[nodiscard]] virtual std::string data_frame() const { return {}; }
  /// What there is to say of the thing that is shown at a place of the fixed frame, or within `radius_m` around it.
  [[nodiscard]] virtual std::string ValueAt(const Eigen::Vector3d& /*at*/, double /*radius_m*/) const { return {}; }
  /// Messages that came, also those that were dropped since.
  [[nodiscard]] virtual std::uint64_t received() const { return 0; }
  /// Messages that came too fast to be shown, or while nothing was taken in.
  [[nodiscard]] virtual std::uint64_t dropped() const { return 0; }
  /// When it changes without a message, on the clock of UpdateContext.
  [[nodiscard]] virtual double next_change_s() const { return std::numeric_limits<double>::infinity(); }
};

}  // namespace hgros::viewer
