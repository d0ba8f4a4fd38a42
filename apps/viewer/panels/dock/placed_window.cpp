#include "viewer/panels/dock/placed_window.hpp"

#include <imgui.h>

#include <algorithm>
#include <utility>

namespace hgros::viewer {
namespace {

PanelPlace MovedInto(const ImVec2& screen, PanelPlace place) {
  place.width = std::min(place.width, screen.x);
  place.height = std::min(place.height, screen.y);
  place.x = std::clamp(place.x, 0.0F, screen.x - place.width);
  place.y = std::clamp(place.y, 0.0F, screen.y - place.height);
  return place;
}

}  // namespace

void PlacedWindow::PlaceNow(const PanelPlace& target) {
  told_ = true;
  ImGui::SetNextWindowPos({target.x, target.y});
  ImGui::SetNextWindowSize({target.width, target.height});
}

void PlacedWindow::Place(const PanelPlace& target) {
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  const bool resized = std::exchange(screen_width_, screen.x) != screen.x;
  const bool resized_too = std::exchange(screen_height_, screen.y) != screen.y;
  if (by_hand_) {
    if (resized || resized_too) PlaceNow(MovedInto(screen, chosen_));
  } else if (target != target_) {
    target_ = target;
    PlaceNow(target);
  }
}

void PlacedWindow::PlaceByHand(const PanelPlace& target) {
  by_hand_ = true;
  chosen_ = target;
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  screen_width_ = screen.x;
  screen_height_ = screen.y;
  PlaceNow(MovedInto(screen, target));
}

void PlacedWindow::Note() {
  const ImVec2 at = ImGui::GetWindowPos();
  const ImVec2 size = ImGui::GetWindowSize();
  PanelPlace now{at.x, at.y, size.x, size.y};
  if (ImGui::IsWindowCollapsed()) {  // It gets its size back when it is unfolded.
    now.width = place_.width;
    now.height = place_.height;
  }
  if (!told_ && now != place_ && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    by_hand_ = true;
    chosen_ = now;
  }
  told_ = false;
  place_ = now;
}

}  // namespace hgros::viewer
