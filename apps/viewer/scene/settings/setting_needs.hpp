#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// Values as text; the key is the setting's name.
using SettingTexts = std::map<std::string, std::string>;

[[nodiscard]] SettingTexts TextsOf(std::span<const Setting> settings);
/// Call it after the settings `given` were set. Sets other settings that these need, unless they were given, too.
/// Returns the names of given settings that differ from `before` and still have no effect.
[[nodiscard]] std::vector<std::string> MeetNeeds(Display& display, std::span<const std::string> given,
                                                 const SettingTexts& before);
/// "lowest has no effect while auto range is on.", or empty if it has an effect.
[[nodiscard]] std::string WhyWithoutEffect(std::span<const Setting> settings, const std::string& name);

}  // namespace hgros::viewer
