#include "viewer/panels/overlay/help_overlay.hpp"

#include <imgui.h>

#include <string>

#include "viewer/panels/overlay/key_table.hpp"

namespace hgros::viewer {
namespace {

void Row(const char* what, const char* meaning) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(what);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(meaning);
}

}  // namespace

void DrawHelp(bool& open) {
  if (!open) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowFocus();
  if (ImGui::Begin("Mouse and keys", &open,
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoMove)) {
    if (ImGui::BeginTable("keys", 2)) {
      Row("Left drag", "turn around the anchor, or the middle of the picture");
      Row("Right drag", "move the picture");
      Row("Wheel", "zoom to the anchor, or to the pointer");
      Row("Left click", "set the anchor on the clicked surface");
      Row("Shift and click", "pick a point; a second point measures the distance");
      std::string keys;
      const auto table = KeyTable();
      for (std::size_t i = 0; i < table.size(); ++i) {
        keys += table[i].name;
        const char* const meaning = table[i].meaning;
        std::size_t next = i + 1;
        while (next < table.size() && table[next].meaning == nullptr) keys += std::string(", ") + table[next++].name;
        Row(keys.c_str(), meaning);
        keys.clear();
        i = next - 1;
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

}  // namespace hgros::viewer
