#include "viewer/panels/dock/panel_dock.hpp"

#include <imgui.h>

#include <algorithm>
#include <utility>

#include "viewer/panels/dock/panel_tiles.hpp"

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
  Opened& opened = opened_.emplace_back(Opened{&type, std::nullopt, {}, type.make({session_, wake})});
  if (const auto before = closed_.find(&type); before != closed_.end()) {
    opened.wanted = before->second.place;
    for (const auto& [name, value] : before->second.settings) (void)opened.panel->Set(name, value);
  }
  Refresh();
  return *opened.panel;
}

void PanelDock::Close(const PanelType& type) {
  const Opened* const open = Find(type);
  if (open == nullptr) return;
  closed_[&type] = KeptLayoutOf(*open);
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

bool PanelDock::HasReceived() const {
  return std::ranges::any_of(opened_, [](const Opened& opened) { return opened.panel->has_received(); });
}

bool PanelDock::NeedsRoom() const {
  return std::ranges::any_of(opened_, [](const Opened& opened) { return !opened.window.by_hand() && !opened.wanted; });
}

float PanelDock::NarrowestWidth() { return kNarrowestPanel * ImGui::GetFontSize(); }

std::vector<PanelPlace> PanelDock::Tiles(const PanelPlace& room) const {
  const float unit = ImGui::GetFontSize();
  std::vector<PanelSize> wanted;
  for (const Opened& opened : opened_) {
    if (!opened.window.by_hand() && !opened.wanted)
      wanted.push_back({opened.type->width * unit, opened.type->height * unit});
  }
  std::vector<PanelPlace> tiles = TilePanels(wanted, room, 0.4F * unit);
  for (PanelPlace& tile : tiles) {
    tile.width = std::max(tile.width, kNarrowestPanel * unit);
    tile.height = std::max(tile.height, kLowestPanel * unit);
  }
  return tiles;
}

bool PanelDock::Draw(Opened& opened, const PanelPlace& tile, PanelWish& wish) {
  const float unit = ImGui::GetFontSize();
  if (opened.wanted) {
    opened.window.PlaceByHand(*opened.wanted);
    opened.wanted.reset();
  } else {
    opened.window.Place(tile);
  }
  ImGui::SetNextWindowSizeConstraints({kNarrowestPanel * unit, kLowestPanel * unit}, {1e5F, 1e5F});
  ImGui::SetNextWindowBgAlpha(1);  // Panels that are read are opaque.
  bool stays = true;
  if (ImGui::Begin(opened.type->name.c_str(), &stays, ImGuiWindowFlags_NoSavedSettings)) opened.panel->Draw(wish);
  opened.window.Note();
  ImGui::End();
  return stays;
}

void PanelDock::Draw(const PanelPlace& room) {
  PanelWish wish;
  const std::vector<PanelPlace> tiles = Tiles(room);
  auto tile = tiles.begin();
  std::vector<const PanelType*> closed;
  for (Opened& opened : opened_) {
    const bool tiled = !opened.window.by_hand() && !opened.wanted;
    if (!Draw(opened, tiled ? *tile++ : PanelPlace(), wish)) closed.push_back(opened.type);
  }
  for (const PanelType* const type : closed) Close(*type);
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

PanelLayout PanelDock::KeptLayoutOf(const Opened& opened) {
  std::optional<PanelPlace> place = opened.wanted;
  if (!place && opened.window.by_hand()) place = opened.window.place();
  return {opened.type->name, place, opened.panel->Settings()};
}

std::vector<PanelLayout> PanelDock::KeptLayout() const {
  std::vector<PanelLayout> all;
  for (const Opened& opened : opened_) all.push_back(KeptLayoutOf(opened));
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
