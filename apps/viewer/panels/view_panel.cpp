#include "viewer/panels/view_panel.hpp"

#include <imgui.h>

#include <algorithm>

namespace hgros::viewer {

std::vector<std::string> FrameNames(const TransformTree& tree) {
  std::vector<std::string> names;
  for (const EdgeSnapshot& edge : tree.Edges()) {
    names.push_back(edge.parent);
    names.push_back(edge.child);
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

bool ViewPanel::Draw(Camera& camera, const FixedFrame& frame, LayoutTarget& file) {
  bool save = false;
  const float unit = ImGui::GetFontSize();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  // It keeps its distance to the nearer edge when the window is resized.
  const bool at_right = place_.x + 0.5F * place_.width > 0.5F * screen_width_;
  if (place_.width == 0) {
    ImGui::SetNextWindowPos({size.x - 0.6F * unit, 0.6F * unit}, ImGuiCond_Always, {1, 0});
  } else if (size.x != screen_width_) {
    const float moved = place_.x + (at_right ? size.x - screen_width_ : 0);
    ImGui::SetNextWindowPos({std::clamp(moved, 0.0F, std::max(0.0F, size.x - place_.width)), place_.y});
  }
  screen_width_ = size.x;
  ImGui::SetNextWindowSizeConstraints({17 * unit, 0}, {17 * unit, size.y});
  ImGui::SetNextWindowCollapsed(true, ImGuiCond_FirstUseEver);
  if (ImGui::Begin("View", nullptr, ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize)) {
    bool orthographic = camera.orthographic();
    if (ImGui::Checkbox("orthographic", &orthographic)) camera.SetOrthographic(orthographic);
    if (ImGui::Button("from above")) camera.LookFromAbove();
    ImGui::SameLine();
    if (ImGui::Button("reset")) camera.Reset();
    ImGui::SetNextItemWidth(9 * unit);
    if (ImGui::BeginCombo("follow", follow_.empty() ? "nothing" : follow_.c_str())) {
      if (ImGui::Selectable("nothing", follow_.empty())) follow_.clear();
      for (const std::string& name : FrameNames(frame.tree())) {
        if (ImGui::Selectable(name.c_str(), name == follow_)) follow_ = name;
      }
      ImGui::EndCombo();
    }
    if (!follow_.empty()) ImGui::Checkbox("with its orientation", &with_rotation_);
    const Eigen::Vector3d pivot = camera.Pivot();
    ImGui::TextDisabled("%s %.2f, %.2f, %.2f m", camera.anchor() ? "anchor" : "middle", pivot.x(), pivot.y(),
                        pivot.z());
    ImGui::Separator();
    save = ImGui::Button("save layout");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Writes displays, panels and camera to %s.", file.Next().c_str());
    ImGui::SameLine();
    ImGui::Checkbox("save on exit", &file.save_on_exit);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "Writes the layout each time the viewer is closed.");
  }
  place_ = {ImGui::GetWindowPos().x, ImGui::GetWindowPos().y, ImGui::GetWindowSize().x, ImGui::GetWindowSize().y};
  ImGui::End();
  return save;
}

}  // namespace hgros::viewer
