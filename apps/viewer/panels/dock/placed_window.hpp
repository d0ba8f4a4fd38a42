#pragma once

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

/// An ImGui window that stays in its automatic place until a user moves or resizes it. Then it stays where the user has
/// put it. If the screen is too small for that place, the window moves into the screen until the screen grows again.
class PlacedWindow {
 public:
  /// Call it before ImGui::Begin with the automatic place.
  void Place(const PanelPlace& target);
  /// The same, but from here on the place is one that a user has chosen.
  void PlaceByHand(const PanelPlace& target);
  /// Call it after ImGui::Begin.
  void Note();

  /// The place that the user has chosen, or else the one at the last Note; all 0 before.
  [[nodiscard]] const PanelPlace& place() const noexcept { return by_hand_ ? chosen_ : place_; }
  [[nodiscard]] bool by_hand() const noexcept { return by_hand_; }

 private:
  void PlaceNow(const PanelPlace& target);

  PanelPlace target_;
  PanelPlace place_;
  PanelPlace chosen_;
  float screen_width_ = 0, screen_height_ = 0;
  bool told_ = false;  ///< The place in this picture was not chosen by a user.
  bool by_hand_ = false;
};

}  // namespace hgros::viewer
