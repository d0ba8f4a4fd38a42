#include "viewer/panels/text_lines.hpp"

#include <imgui.h>

#include "viewer/data/cut_text.hpp"
#include "viewer/panels/look.hpp"

namespace hgros::viewer {

void DrawWarning(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(WarningColor::kRgba[0], WarningColor::kRgba[1], WarningColor::kRgba[2],
                                              WarningColor::kRgba[3]));
  ImGui::TextWrapped("%s", std::string(CutText(text)).c_str());
  ImGui::PopStyleColor();
}

void DrawNote(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextWrapped("%s", std::string(CutText(text)).c_str());
  ImGui::PopStyleColor();
}

}  // namespace hgros::viewer
