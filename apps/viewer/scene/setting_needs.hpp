#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// Values as text, by the setting's name.
using SettingTexts = std::map<std::string, std::string>;

[[nodiscard]] SettingTexts TextsOf(std::span<const Setting> settings);
/// After the settings of those names were given: sets those that they need to count and that nobody has given. Returns
/// the names of those that were changed from `before` and still do not count.
[[nodiscard]] std::vector<std::string> MeetNeeds(Display& display, std::span<const std::string> given,
                                                 const SettingTexts& before);
/// "lowest has no effect while auto range is on."; empty if it has.
[[nodiscard]] std::string WhyWithoutEffect(std::span<const Setting> settings, const std::string& name);

}  // namespace hgros::viewer
