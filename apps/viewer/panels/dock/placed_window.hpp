#pragma once

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

/// An ImGui window that stays in its automatic place until a user moves or resizes it.
class PlacedWindow {
 public:
  /// Call it before ImGui::Begin with the automatic place.
  void Place(const PanelPlace& target);
  /// The same, but from here on the place is one that a user has chosen.
  void PlaceByHand(const PanelPlace& target);
  /// Call it after ImGui::Begin.
  void Note();

  /// The place at the last Note; all 0 before.
  [[nodiscard]] const PanelPlace& place() const noexcept { return place_; }
  [[nodiscard]] bool by_hand() const noexcept { return by_hand_; }

 private:
  PanelPlace target_;
  PanelPlace place_;
  bool told_ = false;  ///< The place in this picture was not chosen by a user.
  bool by_hand_ = false;
};

}  // namespace hgros::viewer
