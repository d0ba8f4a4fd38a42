#include <algorithm>

#include "hgros/base/error.hpp"
#include "viewer/app/layout_file.hpp"
#include "viewer/app/viewer.hpp"
#include "viewer/scene/setting_needs.hpp"

namespace hgros::viewer {

void Viewer::Restore(const Layout& layout) {
  frame_.Ask(layout.fixed_frame);
  view_panel_.Follow(layout.follow, layout.follow_pose);
  if (layout.fps_limit) fps_limit_ = *layout.fps_limit;
  layout_file_.save_on_exit = layout.save_on_exit;
  keeps_finding_ = layout.show_found;
  if (layout.camera) {
    const LayoutCamera& kept = *layout.camera;
    const auto& q = kept.orientation;
    if (kept.anchor) camera_.SetAnchor(Eigen::Vector3d(kept.anchor->data()));
    camera_.Place(Eigen::Vector3d(kept.eye.data()), Eigen::Quaterniond(q[3], q[0], q[1], q[2]), kept.distance);
    camera_.SetOrthographic(kept.orthographic);
    followed_name_ = layout.follow;
    seen_from_followed_ = kept.relative && !layout.follow.empty();
  }
  if (layout.displays) {
    shows_what_it_finds_ = layout.show_found;
    RestoreDisplays(*layout.displays);
  }
  for (const LayoutPanel& panel : layout.panels) {
    const std::string fault = dock_.Restore(panel.panel);
    if (!fault.empty()) throw ConfigError(fault, panel.where);
  }
}

void Viewer::RestoreDisplays(const std::vector<LayoutDisplay>& displays) {
  for (const LayoutDisplay& kept : displays) {
    const DisplayType* const type = DisplayTypeNamed(kept.kind);
    if (type == nullptr) {
      std::string kinds;
      for (const DisplayType& known : DisplayTypes()) kinds += (kinds.empty() ? "" : ", ") + known.name;
      throw ConfigError("There is no display \"" + kept.kind + "\".", kept.where, "There are " + kinds + ".");
    }
    if (type->schemas.empty() != kept.channel.empty()) {
      throw ConfigError(
          "The display \"" + kept.kind + "\" " + (kept.channel.empty() ? "needs a" : "has no") + " channel.",
          kept.where, kept.channel.empty() ? "Write \"channel: NAME\" below its kind." : "Remove the channel.");
    }
    Scene::Entry* opened = nullptr;
    try {
      opened = &Open(*type, kept.channel);
    } catch (const Error& error) {
      throw ConfigError(error.what(), kept.where);
    }
    Scene::Entry& entry = *opened;
    entry.visible = kept.visible;
    const std::vector<Setting> known = entry.display->Settings();
    const SettingTexts before = TextsOf(known);
    std::vector<std::string> given;
    for (const LayoutSetting& setting : kept.settings) {
      const auto found = std::ranges::find(known, setting.name, &Setting::name);
      if (found == known.end()) {
        std::string names;
        for (const Setting& other : known) names += (names.empty() ? "" : ", ") + other.name;
        throw ConfigError("\"" + kept.kind + "\" has no setting \"" + setting.name + "\".", setting.where,
                          "There are " + names + ".");
      }
      if (const std::string fault = SetFromText(*found, setting.value); !fault.empty()) {
        throw ConfigError(fault, setting.where);
      }
      entry.display->OnSetting(setting.name);
      given.push_back(setting.name);
    }
    entry.without_effect = MeetNeeds(*entry.display, given, before);
    shown_by_itself_.insert(kept.channel);
  }
}

Layout Viewer::CurrentLayout() const {
  Layout layout;
  if (!frame_.chosen()) layout.fixed_frame = frame_.name();
  layout.follow = view_panel_.follow();
  layout.follow_pose = view_panel_.with_rotation();
  layout.fps_limit = fps_limit_;
  layout.save_on_exit = layout_file_.save_on_exit;
  LayoutCamera& kept = layout.camera.emplace();
  const bool follows = followed_ && followed_name_ == layout.follow;
  kept.relative = follows || seen_from_followed_;
  Camera camera = camera_;
  if (follows) camera.Follow(*followed_, RigidTransform(), layout.follow_pose);
  std::ranges::copy(camera.eye(), kept.eye.begin());
  std::ranges::copy(camera.orientation().coeffs(), kept.orientation.begin());
  kept.distance = camera.distance();
  kept.orthographic = camera.orthographic();
  if (camera.anchor()) std::ranges::copy(*camera.anchor(), kept.anchor.emplace().begin());
  layout.show_found = shows_what_it_finds_;
  layout.displays.emplace();
  for (const Scene::Entry& entry : scene_.entries()) {
    LayoutDisplay& display = layout.displays->emplace_back();
    display.kind = entry.type->name;
    display.channel = entry.channel;
    display.visible = entry.visible;
    for (const Setting& setting : entry.display->Settings()) {
      display.settings.push_back({setting.name, TextOf(setting), {}});
    }
  }
  for (const PanelLayout& panel : dock_.KeptLayout()) layout.panels.push_back({panel, {}});
  return layout;
}

Carried Viewer::Carry() const { return {awaited_, shown_by_itself_, keeps_finding_}; }

void Viewer::TakeOver(Carried carried) {
  shown_by_itself_.merge(carried.found);
  keeps_finding_ = carried.keeps_finding;
}

void Viewer::AddPanels() {
  for (const WantedDisplay& wanted : options_.opened_panels) {
    const std::string fault = dock_.Restore({wanted.channel, std::nullopt, wanted.settings});
    if (!fault.empty()) throw Error(fault);
  }
}

void Viewer::SaveLayoutNow() {
  Layout layout = CurrentLayout();
  layout.show_found = keeps_finding_;
  const std::string fault = SaveLayout(layout, layout_file_.path);
  std::error_code ignored;
  notice_ = "wrote " + std::filesystem::absolute(layout_file_.path, ignored).string();
  if (!fault.empty()) Complain(fault);
  frames_wanted_ = 3;
}

}  // namespace hgros::viewer
