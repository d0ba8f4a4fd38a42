#include "viewer/panels/panel_dock.hpp"

#include <imgui.h>

#include <algorithm>
#include <utility>

namespace hgros::viewer {

PanelDock::PanelDock(Session& session, std::function<void()> wake) : session_(session), wake_(std::move(wake)) {}

const PanelDock::Opened* PanelDock::Find(const PanelType& type) const {
  const auto found = std::ranges::find(opened_, &type, &Opened::type);
  return found == opened_.end() ? nullptr : &*found;
}

bool PanelDock::IsOpen(const PanelType& type) const { return Find(type) != nullptr; }

Panel& PanelDock::Open(const PanelType& type) {
  if (const Opened* const there = Find(type)) return *there->panel;
  const auto wake = [arrived = arrived_, wake = wake_] {
    if (!arrived->exchange(true)) wake();
  };
  opened_.push_back({&type, std::nullopt, {}, type.make({session_, wake})});
  Refresh();
  return *opened_.back().panel;
}

void PanelDock::Close(const PanelType& type) {
  std::erase_if(opened_, [&](const Opened& opened) { return opened.type == &type; });
}

void PanelDock::Toggle(const PanelType& type) {
  if (IsOpen(type)) {
    Close(type);
  } else {
    Open(type);
  }
}

double PanelDock::next_change_s() const {
  if (opened_.empty()) return kNever;
  if (last_update_s_ == -kNever) return -kNever;
  double next = *arrived_ ? last_update_s_ + kPeriodS : kNever;
  for (const Opened& opened : opened_) next = std::min(next, opened.panel->next_change_s());
  return std::max(next, last_update_s_ + kPeriodS);
}

bool PanelDock::Update(const PanelContext& context) {
  if (context.now_s < next_change_s()) return false;
  arrived_->store(false);
  last_update_s_ = context.now_s;
  for (const Opened& opened : opened_) opened.panel->Update(context);
  return true;
}

bool PanelDock::Draw(Opened& opened, PanelWish& wish) const {
  const float unit = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  if (opened.wanted) {
    ImGui::SetNextWindowPos({opened.wanted->x, opened.wanted->y});
    ImGui::SetNextWindowSize({opened.wanted->width, opened.wanted->height});
    opened.wanted.reset();
  } else {
    // Beside the list of displays, from the lower edge up; the time bar has its place below.
    const float left = 22.2F * unit;
    const float lower = screen.y - ImGui::GetFrameHeight() - 3.2F * unit;
    const auto place = static_cast<float>(&opened - opened_.data());
    const ImVec2 size(std::clamp(opened.type->width * unit, 12 * unit, std::max(12 * unit, screen.x - left - unit)),
                      std::min(opened.type->height * unit, std::max(8 * unit, lower - unit)));
    // Above the one that was opened before, if there is room; else over all of them, but for their titles.
    const float above = &opened == opened_.data() ? 0 : (&opened)[-1].place.y - size.y - 0.4F * unit;
    const bool fits = above >= 0.6F * unit;
    const float top = fits ? above : std::max(0.6F * unit, lower - size.y - place * 2 * unit);
    ImGui::SetNextWindowPos({left + (fits ? 0 : place * 1.2F * unit), top}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize(size, ImGuiCond_FirstUseEver);
  }
  ImGui::SetNextWindowSizeConstraints({12 * unit, 6 * unit}, {1e5F, 1e5F});
  ImGui::SetNextWindowBgAlpha(1);  // What is read need not be seen through.
  bool stays = true;
  if (ImGui::Begin(opened.type->name.c_str(), &stays, ImGuiWindowFlags_NoSavedSettings)) opened.panel->Draw(wish);
  opened.place = {ImGui::GetWindowPos().x, ImGui::GetWindowPos().y, ImGui::GetWindowSize().x, ImGui::GetWindowSize().y};
  ImGui::End();
  return stays;
}

void PanelDock::Draw() {
  PanelWish wish;
  std::erase_if(opened_, [&](Opened& opened) { return !Draw(opened, wish); });
  if (!wish.message.empty()) (void)Open(*PanelTypeNamed("Message")).Set("channel", wish.message);
  if (!wish.plot.empty()) (void)Open(*PanelTypeNamed("Plot")).Set("series", wish.plot);
  if (!wish.message.empty() || !wish.plot.empty()) Refresh();
}

void PanelDock::DrawSwitches() {
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  for (const PanelType& type : PanelTypes()) {
    const float width = ImGui::CalcTextSize(type.name.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (&type != PanelTypes().data()) {
      ImGui::SameLine(0, 4);
      if (ImGui::GetCursorScreenPos().x + width > right) ImGui::NewLine();
    }
    const bool open = IsOpen(type);
    if (open) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    if (ImGui::SmallButton(type.name.c_str())) Toggle(type);
    if (open) ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", type.meaning.c_str());
  }
}

std::vector<PanelLayout> PanelDock::Layout() const {
  std::vector<PanelLayout> all;
  for (const Opened& opened : opened_) {
    const bool drawn = opened.place.width > 0;
    all.push_back({opened.type->name, drawn ? std::optional(opened.place) : opened.wanted, opened.panel->Settings()});
  }
  return all;
}

std::string PanelDock::Restore(const PanelLayout& layout) {
  const PanelType* const type = PanelTypeNamed(layout.name);
  if (type == nullptr) {
    std::string names;
    for (const PanelType& known : PanelTypes()) names += (names.empty() ? "" : ", ") + known.name;
    return "There is no panel \"" + layout.name + "\"; there are " + names + ".";
  }
  Panel& panel = Open(*type);
  if (layout.place) std::ranges::find(opened_, type, &Opened::type)->wanted = layout.place;
  for (const auto& [name, value] : layout.settings) {
    if (std::string fault = panel.Set(name, value); !fault.empty()) return fault;
  }
  return {};
}

}  // namespace hgros::viewer
