#include "viewer/panels/widgets/channel_combo.hpp"

#include <imgui.h>

namespace hgros::viewer {

bool DrawChannelCombo(const char* label, std::string& channel, std::span<const KnownChannel> channels) {
  if (!ImGui::BeginCombo(label, channel.empty() ? "choose a channel" : channel.c_str(), ImGuiComboFlags_HeightLarge)) {
    return false;
  }
  bool other = false;
  if (channels.empty()) ImGui::TextDisabled("No channels have been found yet.");
  for (const KnownChannel& known : channels) {
    ImGui::PushID(known.name.c_str());
    if (ImGui::Selectable(known.name.c_str(), known.name == channel)) {
      other = known.name != channel;
      channel = known.name;
    }
    ImGui::SameLine();
    ImGui::TextDisabled("%s", known.type_name.c_str());
    ImGui::PopID();
  }
  ImGui::EndCombo();
  return other;
}

}  // namespace hgros::viewer
