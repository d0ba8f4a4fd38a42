#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "viewer/app/viewer.hpp"
#include "viewer/data/type_conflict.hpp"
#include "viewer/scene/setting_needs.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostByThemselves = 32;

std::string Listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Why --display cannot have that one.
std::string WhyNoDisplay(const std::string& name) {
  std::vector<std::string> alone;
  std::vector<std::string> of_channels;
  for (const DisplayType& type : DisplayTypes()) (type.schemas.empty() ? alone : of_channels).push_back(type.name);
  if (std::ranges::find(of_channels, name) != of_channels.end()) {
    return "The display \"" + name + "\" shows a channel: ask for it by --channel NAME. --display takes " +
           Listed(alone) + ".";
  }
  std::vector<std::string> all = alone;
  all.insert(all.end(), of_channels.begin(), of_channels.end());
  const std::string nearest = name.size() <= 64 ? NearestName(name, all) : std::string();
  return "There is no display \"" + name + "\" for --display." +
         (nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?") + " It takes " + Listed(alone) +
         "; --channel shows channels as " + Listed(of_channels) + ".";
}

}  // namespace

void Viewer::AddWanted() {
  for (const WantedDisplay& wanted : options_.channels) {
    if (wanted.schema.empty()) {
      awaited_.push_back(wanted);
      continue;
    }
    const DisplayType* const type = DisplayTypeFor(wanted.schema);
    if (type == nullptr) throw Error("No display shows channels of \"" + wanted.schema + "\".");
    Add(*type, wanted.channel, wanted.settings);
  }
  for (const WantedDisplay& wanted : options_.displays) {
    auto& entries = scene_.entries();
    auto entry = std::ranges::find(entries, wanted.channel, &Scene::Entry::name);
    if (entry == entries.end() || entry->type == DisplayTypeNamed("Robot model")) {
      const DisplayType* const type = DisplayTypeNamed(wanted.channel);
      if (type == nullptr || !type->schemas.empty()) {
        throw Error(WhyNoDisplay(wanted.channel));
      }
      Add(*type, "", {});
      entry = std::prev(entries.end());
    }
    Set(*entry, wanted.settings);
  }
}

// Once a publisher tells its schema: what was asked for by name, or, if nothing was, all that can be shown.
void Viewer::TakeChannels() {
  if (!channels_changed_.exchange(false)) return;
  channels_.clear();
  known_ = session_.Channels();
  std::erase_if(known_, [](const KnownChannel& known) { return known.name.starts_with("hgros/"); });
  for (const KnownChannel& known : known_) {
    if (known.publishers.empty()) continue;
    channels_.push_back({known.name, known.type_name, TypeConflict(known)});
    const DisplayType* const type = DisplayTypeFor(known.type_name);
    const auto awaited = std::ranges::find(awaited_, known.name, &WantedDisplay::channel);
    if (awaited != awaited_.end()) {
      const WantedDisplay wanted = std::move(*awaited);
      awaited_.erase(awaited);
      if (type == nullptr) {
        notice_ = "No display shows \"" + known.name + "\", which carries " + known.type_name + ".";
        std::fprintf(stderr, "hgros-viewer: %s\n", notice_.c_str());
      }
      if (type == nullptr || !AddOrSay(*type, wanted)) unmet_ = true;
    } else if (shows_what_it_finds_ && type != nullptr && shown_by_itself_.size() < kMostByThemselves &&
               shown_by_itself_.insert(known.name).second) {
      AddOrSay(*type, {known.name, {}, {}});
    }
  }
  SayMismatches();
  dock_.Refresh();
  next_count_s_ = std::min(next_count_s_, last_turn_s_);
  frames_wanted_ = kFramesAfterInput;
}

// The channel's publisher may have come long after the arguments were read: what is wrong with them ends nothing now.
bool Viewer::AddOrSay(const DisplayType& type, const WantedDisplay& wanted) {
  try {
    Add(type, wanted.channel, wanted.settings);
    return true;
  } catch (const Error& error) {
    notice_ = error.what();
    std::fprintf(stderr, "hgros-viewer: %s\n", error.what());
    return false;
  }
}

void Viewer::Add(const DisplayType& type, const std::string& channel,
                 const std::vector<std::pair<std::string, std::string>>& settings) {
  Set(Open(type, channel), settings);
}

void Viewer::Set(Scene::Entry& entry, const std::vector<std::pair<std::string, std::string>>& settings) {
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
      std::string names;
      for (const Setting& other : known) names += (names.empty() ? "" : ", ") + other.name;
      throw Error("\"" + entry.name + "\" has no setting \"" + name + "\"; there are " + names + ".");
    }
    if (const std::string fault = SetFromText(*setting, value); !fault.empty()) throw Error(fault);
    entry.display->OnSetting(name);
    given.push_back(name);
  }
  entry.without_effect = MeetNeeds(*entry.display, given, before);
}

}  // namespace hgros::viewer
