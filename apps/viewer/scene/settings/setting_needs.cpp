#include "viewer/scene/settings/setting_needs.hpp"

#include <algorithm>
#include <set>

namespace hgros::viewer {
namespace {

const Setting* Find(std::span<const Setting> settings, const std::string& name) {
  const auto found = std::ranges::find(settings, name, &Setting::name);
  return found == settings.end() ? nullptr : &*found;
}

/// The first need that is not met, or null.
const Setting::Need* Unmet(std::span<const Setting> settings, const Setting& setting) {
  for (const Setting::Need& need : setting.needs) {
    const Setting* const other = Find(settings, need.name);
    if (other != nullptr && std::ranges::find(need.values, TextOf(*other)) == need.values.end()) return &need;
  }
  return nullptr;
}

}  // namespace

SettingTexts TextsOf(std::span<const Setting> settings) {
  SettingTexts texts;
  for (const Setting& setting : settings) texts[setting.name] = TextOf(setting);
  return texts;
}

std::vector<std::string> MeetNeeds(Display& display, std::span<const std::string> given, const SettingTexts& before) {
  std::set<std::string> decided(given.begin(), given.end());
  const std::vector<Setting> settings = display.Settings();
  for (const std::string& name : given) {
    const Setting* const setting = Find(settings, name);
    if (setting == nullptr) continue;
    for (const Setting::Need* need = Unmet(settings, *setting); need != nullptr && decided.insert(need->name).second;
         need = Unmet(settings, *setting)) {
      (void)SetFromText(*Find(settings, need->name), need->values.front());
      display.OnSetting(need->name);
    }
  }
  std::vector<std::string> without_effect;
  for (const std::string& name : given) {
    const Setting* const setting = Find(settings, name);
    if (setting == nullptr || Unmet(settings, *setting) == nullptr) continue;
    const auto was = before.find(name);
    if (was == before.end() || was->second != TextOf(*setting)) without_effect.push_back(name);
  }
  return without_effect;
}

std::string WhyWithoutEffect(std::span<const Setting> settings, const std::string& name) {
  const Setting* const setting = Find(settings, name);
  const Setting::Need* const need = setting == nullptr ? nullptr : Unmet(settings, *setting);
  if (need == nullptr) return {};
  return name + " has no effect while " + need->name + " is " + TextOf(*Find(settings, need->name)) + ".";
}

}  // namespace hgros::viewer
