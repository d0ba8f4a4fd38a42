#include "viewer/app/displays/display_settings.hpp"

#include <algorithm>

#include "hgros/base/error.hpp"
#include "viewer/scene/settings/setting_needs.hpp"

namespace hgros::viewer {
namespace {

std::string NamesOf(const std::vector<Setting>& settings) {
  std::string names;
  for (const Setting& setting : settings) names += (names.empty() ? "" : ", ") + setting.name;
  return names;
}

}  // namespace

void ApplySettings(Scene::Entry& entry, const std::vector<std::pair<std::string, std::string>>& settings) {
  const SettingTexts before = TextsOf(entry.display->Settings());
  std::vector<std::string> given;
  for (const auto& [name, value] : settings) {
    if (name == "visible") {
      entry.visible = value == "on" || value == "true";
      if (!entry.visible && value != "off" && value != "false") {
        throw Error("visible is on or off, not \"" + value + "\".");
      }
      continue;
    }
    const std::vector<Setting> known = entry.display->Settings();
    const auto setting = std::ranges::find(known, name, &Setting::name);
    if (setting == known.end()) {
      throw Error("\"" + entry.name + "\" has no setting \"" + name + "\"; there are " + NamesOf(known) + ".");
    }
    if (const std::string fault = SetFromText(*setting, value); !fault.empty()) throw Error(fault);
    entry.display->OnSetting(name);
    given.push_back(name);
  }
  entry.without_effect = MeetNeeds(*entry.display, given, before);
}

void ApplySettings(Scene::Entry& entry, const LayoutDisplay& kept) {
  entry.visible = kept.visible;
  const std::vector<Setting> known = entry.display->Settings();
  const SettingTexts before = TextsOf(known);
  std::vector<std::string> given;
  for (const LayoutSetting& setting : kept.settings) {
    const auto found = std::ranges::find(known, setting.name, &Setting::name);
    if (found == known.end()) {
      throw ConfigError("\"" + kept.kind + "\" has no setting \"" + setting.name + "\".", setting.where,
                        "There are " + NamesOf(known) + ".");
    }
    if (const std::string fault = SetFromText(*found, setting.value); !fault.empty()) {
      throw ConfigError(fault, setting.where);
    }
    entry.display->OnSetting(setting.name);
    given.push_back(setting.name);
  }
  entry.without_effect = MeetNeeds(*entry.display, given, before);
}

std::vector<LayoutDisplay> KeptDisplays(const Scene& scene) {
  std::vector<LayoutDisplay> displays;
  for (const Scene::Entry& entry : scene.entries()) {
    LayoutDisplay& display = displays.emplace_back();
    display.kind = entry.type->name;
    display.channel = entry.channel;
    display.visible = entry.visible;
    for (const Setting& setting : entry.display->Settings()) {
      if (setting.decided) display.settings.push_back({setting.name, TextOf(setting), {}});
    }
  }
  return displays;
}

}  // namespace hgros::viewer
