#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/panels/dock/panel_place.hpp"
#include "viewer/panels/layout_target.hpp"
#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// The panel View: camera settings, and the frame that the camera follows.
class ViewPanel {
 public:
  /// Returns whether the layout is to be written now.
  [[nodiscard]] bool Draw(Camera& camera, const FixedFrame& frame, LayoutTarget& file);

  /// Empty: none.
  void Follow(std::string_view frame, bool with_rotation) {
    follow_ = frame;
    with_rotation_ = with_rotation;
  }
  [[nodiscard]] const std::string& follow() const noexcept { return follow_; }
  [[nodiscard]] bool with_rotation() const noexcept { return with_rotation_; }

 private:
  std::string follow_;
  bool with_rotation_ = false;
  PanelPlace place_;
  float screen_width_ = 0;
};

/// The names of all frames, sorted.
[[nodiscard]] std::vector<std::string> FrameNames(const TransformTree& tree);

}  // namespace hgros::viewer
