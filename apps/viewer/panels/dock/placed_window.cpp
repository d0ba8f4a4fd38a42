#include "viewer/panels/dock/placed_window.hpp"

#include <imgui.h>

namespace hgros::viewer {

void PlacedWindow::Place(const PanelPlace& target) {
  if (by_hand_ || target == target_) return;
  target_ = target;
  told_ = true;
  ImGui::SetNextWindowPos({target.x, target.y});
  ImGui::SetNextWindowSize({target.width, target.height});
}

void PlacedWindow::PlaceByHand(const PanelPlace& target) {
  by_hand_ = false;
  target_ = {};
  Place(target);
  by_hand_ = true;
}

void PlacedWindow::Note() {
  const ImVec2 at = ImGui::GetWindowPos();
  const ImVec2 size = ImGui::GetWindowSize();
  PanelPlace now{at.x, at.y, size.x, size.y};
  if (ImGui::IsWindowCollapsed()) {  // It gets its size back when it is unfolded.
    now.width = place_.width;
    now.height = place_.height;
  }
  if (!told_ && now != place_ && ImGui::IsMouseDown(ImGuiMouseButton_Left)) by_hand_ = true;
  told_ = false;
  place_ = now;
}

}  // namespace hgros::viewer
