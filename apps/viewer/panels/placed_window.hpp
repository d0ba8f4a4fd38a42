#pragma once

#include "viewer/panels/panel_place.hpp"

namespace hgros::viewer {

/// A window of ImGui that lies where it belongs, also when that is elsewhere, until a person has moved or resized it.
class PlacedWindow {
 public:
  /// Before ImGui::Begin: where it belongs.
  void Place(const PanelPlace& target);
  /// Likewise, but from here on it is a person's.
  void PlaceByHand(const PanelPlace& target);
  /// Behind ImGui::Begin.
  void Note();

  /// As of the last Note; all 0 before.
  [[nodiscard]] const PanelPlace& place() const noexcept { return place_; }
  [[nodiscard]] bool by_hand() const noexcept { return by_hand_; }

 private:
  PanelPlace target_;
  PanelPlace place_;
  bool told_ = false;  ///< The place of this picture is no person's doing.
  bool by_hand_ = false;
};

}  // namespace hgros::viewer
