#include "viewer/panels/widgets/text_lines.hpp"

#include <imgui.h>

#include "viewer/data/cut_text.hpp"
#include "viewer/panels/widgets/look.hpp"

namespace hgros::viewer {

void PushWarningColor() {
  const float* const rgba = WarningColor::kRgba;
  ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(rgba[0], rgba[1], rgba[2], rgba[3]));
}

void DrawWarning(const std::string& text) {
  PushWarningColor();
  ImGui::TextWrapped("%s", std::string(CutText(text)).c_str());
  ImGui::PopStyleColor();
}

void DrawTooltip(const std::string& text) {
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(32 * ImGui::GetFontSize());
  ImGui::TextUnformatted(std::string(CutText(text)).c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void DrawNote(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextWrapped("%s", std::string(CutText(text)).c_str());
  ImGui::PopStyleColor();
}

void SameLineFor(const std::string& text) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float width = ImGui::CalcTextSize(text.c_str()).x + 2 * style.FramePadding.x;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  if (ImGui::GetItemRectMax().x + style.ItemSpacing.x + width <= right) ImGui::SameLine();
}

}  // namespace hgros::viewer
