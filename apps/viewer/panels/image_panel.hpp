#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "viewer/panels/dock/panel_place.hpp"
#include "viewer/panels/dock/placed_window.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// A window for each display with an image, with the value under the pointer. The wheel zooms, a drag moves, a double
/// click shows the whole image again. Windows that nobody has moved share a part of the room at its right side.
class ImagePanel {
 public:
  /// Draws the images. `room` is for them and for panels that need at least `reserved` of its width. Returns what is
  /// left for those.
  PanelPlace Draw(const Scene& scene, const PanelPlace& room, float reserved);

  /// Where a user has put the window of that display; none: nobody has moved it.
  [[nodiscard]] std::optional<PanelPlace> PlaceOf(const Display& display) const;
  /// The same place again, from a layout.
  void Restore(const Display& display, const PanelPlace& place) { windows_[&display].wanted = place; }

 private:
  struct ImageWindow {
    std::size_t number = 0;            ///< Distinguishes windows of the same channel; 0: it was not drawn yet.
    std::optional<PanelPlace> wanted;  ///< The place for the next Draw.
    PlacedWindow window;
    // The visible part of the image.
    float zoom = 1;  ///< 1: the whole image.
    float middle_x = 0.5F, middle_y = 0.5F;
  };
  /// An image in this picture.
  struct Shown {
    const Scene::Entry* entry;
    ShownImage image;
    ImageWindow* window;
  };
  [[nodiscard]] std::vector<Shown> ShownImages(const Scene& scene);
  static void DrawWindow(const Shown& shown, const PanelPlace& tile);
  static void DrawImage(const Shown& shown);

  std::map<const Display*, ImageWindow> windows_;
  std::size_t numbers_ = 0;
};

}  // namespace hgros::viewer
