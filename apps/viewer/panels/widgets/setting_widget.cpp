#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "viewer/panels/display_panel.hpp"

namespace hgros::viewer {
namespace {

struct Widget {
  const char* name;

  bool operator()(const Setting::Switch& on) const { return ImGui::Checkbox(name, on.value); }
  bool operator()(const Setting::Number& number) const {
    const std::string format = number.unit.empty() ? "%.4g" : "%.4g " + number.unit;
    const float speed = std::max(0.01F * *number.value, 1e-3F);
    return ImGui::DragFloat(name, number.value, speed, number.lowest, number.highest, format.c_str(),
                            ImGuiSliderFlags_AlwaysClamp);
  }
  bool operator()(const Setting::Choice& choice) const {
    bool changed = false;
    if (ImGui::BeginCombo(name, choice.names[static_cast<std::size_t>(*choice.value)].c_str())) {
      for (std::size_t i = 0; i < choice.names.size(); ++i) {
        const bool selected = static_cast<std::size_t>(*choice.value) == i;
        if (ImGui::Selectable(choice.names[i].c_str(), selected) && !selected) {
          *choice.value = static_cast<int>(i);
          changed = true;
        }
      }
      ImGui::EndCombo();
    }
    return changed;
  }
  bool operator()(const Setting::Color& color) const {
    return ImGui::ColorEdit3(name, color.value->data(), ImGuiColorEditFlags_NoInputs);
  }
  bool operator()(const Setting::Text& text) const {
    char words[1024];
    std::snprintf(words, sizeof words, "%s", text.value->c_str());
    if (!ImGui::InputText(name, words, sizeof words, ImGuiInputTextFlags_EnterReturnsTrue)) return false;
    *text.value = words;
    return true;
  }
};

}  // namespace

bool DrawSetting(const Setting& setting) {
  ImGui::SetNextItemWidth(0.5F * ImGui::GetContentRegionAvail().x);
  const bool changed = std::visit(Widget{setting.name.c_str()}, setting.value);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", setting.meaning.c_str());
  return changed;
}

}  // namespace hgros::viewer
