#include "viewer/panels/display_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <utility>

#include "viewer/panels/view_panel.hpp"
#include "viewer/panels/widgets/text_lines.hpp"
#include "viewer/scene/settings/setting_needs.hpp"

namespace hgros::viewer {
namespace {

/// Lines of a status before it scrolls, so that the settings stay visible.
constexpr std::size_t kMostStatusLines = 7;

void DrawStatus(const std::vector<std::string>& lines, bool warns) {
  const bool many = lines.size() > kMostStatusLines;
  const float height = static_cast<float>(kMostStatusLines) * ImGui::GetTextLineHeightWithSpacing();
  if (many) ImGui::BeginChild("##status", {0, height});
  for (const std::string& line : lines) std::exchange(warns, false) ? DrawWarning(line) : DrawNote(line);
  if (many) ImGui::EndChild();
}

}  // namespace

DisplayPanel::Wish DisplayPanel::Draw(Scene& scene, const FixedFrame& frame, const std::vector<ChannelRow>& channels,
                                      PanelDock& dock) {
  Wish wish;
  const float unit = ImGui::GetFontSize();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  window_.Place({0.6F * unit, 0.6F * unit, 21 * unit, std::clamp(size.y - 4 * unit, 6 * unit, 40 * unit)});
  const bool open = ImGui::Begin("Displays", nullptr, ImGuiWindowFlags_NoSavedSettings);
  window_.Note();
  if (open) {
    dock.DrawSwitches();
    ImGui::Separator();
    DrawFrame(frame, wish);
    ImGui::Separator();
    static const std::string none;
    for (std::size_t i = 0; i < scene.entries().size(); ++i) {
      const auto row = std::ranges::find(channels, scene.entries()[i].channel, &ChannelRow::name);
      DrawEntry(scene, i, row == channels.end() ? none : row->conflict, wish);
    }
    ImGui::Separator();
    DrawAdd(channels, wish);
    if (!refusal_.empty()) DrawWarning(refusal_);
  }
  ImGui::End();
  return wish;
}

void DisplayPanel::DrawFrame(const FixedFrame& frame, Wish& wish) {
  ImGui::SetNextItemWidth(0.5F * ImGui::GetContentRegionAvail().x);
  const std::string shown = frame.name().empty() ? "none yet" : frame.name() + (frame.chosen() ? " (chosen)" : "");
  if (!ImGui::BeginCombo("fixed frame", shown.c_str())) return;
  if (ImGui::Selectable("choose automatically", frame.chosen())) {
    wish.set_fixed_frame = true;
  }
  for (const std::string& name : FrameNames(frame.tree())) {
    if (ImGui::Selectable(name.c_str(), name == frame.name())) {
      wish.set_fixed_frame = true;
      wish.fixed_frame = name;
    }
  }
  ImGui::EndCombo();
}

void DisplayPanel::DrawEntry(Scene& scene, std::size_t index, const std::string& conflict, Wish& wish) {
  Scene::Entry& entry = scene.entries()[index];
  ImGui::PushID(entry.display.get());
  bool visible = entry.visible;
  if (ImGui::Checkbox("##visible", &visible)) scene.SetVisible(index, visible);
  ImGui::SameLine();
  const std::string& misuse = entry.mismatch.empty() ? conflict : entry.mismatch;
  const bool fault = entry.display->HasFault() || entry.still_unreadable || !misuse.empty();
  if (fault) PushWarningColor();
  const bool unfolded = ImGui::TreeNodeEx("##entry", ImGuiTreeNodeFlags_SpanAvailWidth, "%s", entry.name.c_str());
  if (fault) ImGui::PopStyleColor();
  if (ImGui::IsItemHovered()) {
    if (!misuse.empty()) {
      DrawTooltip(misuse);
    } else if (entry.display->HasFault()) {
      DrawTooltip(entry.display->Status().front());
    }
  }
  if (entry.name != entry.type->name) {
    ImGui::SameLine();
    ImGui::TextDisabled("%s", entry.type->name.c_str());
  }
  if (unfolded) {
    if (!misuse.empty()) DrawWarning(misuse);
    std::vector<std::string> status = entry.display->Status();
    if (!entry.mismatch.empty()) std::erase(status, "Nothing has arrived yet.");
    DrawStatus(status, entry.display->HasFault());
    if (entry.unreadable > 0) {
      const std::string line =
          std::to_string(entry.unreadable) +
          (entry.unreadable == 1 ? " message does not match its publisher's type: its bytes are not a "
                                 : " messages do not match their publisher's type: their bytes are not a ") +
          entry.type->schemas.front() + ".";
      entry.still_unreadable ? DrawWarning(line) : DrawNote(line);
    }
    const std::vector<Setting> settings = entry.display->Settings();
    for (const std::string& name : entry.without_effect) {
      if (const std::string why = WhyWithoutEffect(settings, name); !why.empty()) DrawNote(why);
    }
    for (const Setting& setting : settings) {
      if (setting.shown && !setting.shown()) continue;
      if (!DrawSetting(setting)) continue;
      entry.display->OnSetting(setting.name);
      scene.Redraw();
    }
    if (ImGui::SmallButton("clear")) {
      entry.display->Clear();
      scene.Redraw();
    }
    ImGui::SameLine();
    if (ImGui::SmallButton("up")) scene.MoveUp(index);
    ImGui::SameLine();
    if (ImGui::SmallButton("remove")) wish.remove = index;
    ImGui::TreePop();
  }
  ImGui::PopID();
}

void DisplayPanel::DrawAdd(const std::vector<ChannelRow>& channels, Wish& wish) {
  if (!channels.empty() && ImGui::TreeNode("Channels##that_are_published")) {
    for (const ChannelRow& row : channels) {
      const DisplayType* const type = DisplayTypeFor(row.schema);
      ImGui::PushID(row.name.c_str());
      if (type != nullptr && ImGui::SmallButton("show")) {
        wish.add = type;
        wish.channel = row.name;
      }
      if (type != nullptr) ImGui::SameLine();
      if (!row.conflict.empty()) PushWarningColor();
      ImGui::TextUnformatted(row.name.c_str());
      if (!row.conflict.empty()) ImGui::PopStyleColor();
      if (!row.conflict.empty() && ImGui::IsItemHovered()) DrawTooltip(row.conflict);
      ImGui::SameLine();
      ImGui::TextDisabled("%s", row.schema.c_str());
      ImGui::PopID();
    }
    ImGui::TreePop();
  }
  if (!ImGui::TreeNode("Add a display")) return;
  const auto types = DisplayTypes();
  const DisplayType& type = types[static_cast<std::size_t>(type_)];
  if (ImGui::BeginCombo("kind", type.name.c_str())) {
    for (std::size_t i = 0; i < types.size(); ++i) {
      if (!ImGui::Selectable(types[i].name.c_str(), static_cast<int>(i) == type_)) continue;
      type_ = static_cast<int>(i);
      refusal_.clear();
    }
    ImGui::EndCombo();
  }
  const bool needs_channel = !type.schemas.empty();
  if (needs_channel && ImGui::InputText("channel", channel_, sizeof channel_)) refusal_.clear();
  if (ImGui::Button("add") && (!needs_channel || channel_[0] != '\0')) {
    wish.add = &type;
    wish.channel = needs_channel ? channel_ : "";
  }
  ImGui::TreePop();
}

}  // namespace hgros::viewer
