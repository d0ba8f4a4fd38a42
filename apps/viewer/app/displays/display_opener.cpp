#include "viewer/app/displays/display_opener.hpp"

#include <algorithm>
#include <iterator>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "viewer/app/displays/display_settings.hpp"
#include "viewer/scene/type_mismatch.hpp"

namespace hgros::viewer {
namespace {

std::string JoinNames(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Why --display does not accept that name.
std::string WhyNoDisplay(const std::string& name) {
  std::vector<std::string> alone;
  std::vector<std::string> of_channels;
  for (const DisplayType& type : DisplayTypes()) (type.schemas.empty() ? alone : of_channels).push_back(type.name);
  if (std::ranges::find(of_channels, name) != of_channels.end()) {
    return "The display \"" + name + "\" shows a channel: ask for it by --channel NAME. --display takes " +
           JoinNames(alone) + ".";
  }
  std::vector<std::string> all = alone;
  all.insert(all.end(), of_channels.begin(), of_channels.end());
  const std::string nearest = name.size() <= 64 ? NearestName(name, all) : std::string();
  return "There is no display \"" + name + "\" for --display." +
         (nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?") + " It takes " + JoinNames(alone) +
         "; --channel shows channels as " + JoinNames(of_channels) + ".";
}

}  // namespace

void DisplayOpener::AddDefaults() {
  Add(*DisplayTypeNamed("Ground"), "", {});
  Add(*DisplayTypeNamed("Frames"), "", {});
}

void DisplayOpener::AddRequested(const Options& options) {
  for (const WantedDisplay& wanted : options.channels) {
    if (wanted.schema.empty()) {
      awaited_.push_back(wanted);
      continue;
    }
    const DisplayType* const type = DisplayTypeFor(wanted.schema);
    if (type == nullptr) throw Error("No display shows channels of \"" + wanted.schema + "\".");
    Add(*type, wanted.channel, wanted.settings);
  }
  for (const WantedDisplay& wanted : options.displays) {
    auto& entries = scene_.entries();
    auto entry = std::ranges::find(entries, wanted.channel, &Scene::Entry::name);
    if (entry == entries.end() || entry->type == DisplayTypeNamed("Robot model")) {
      const DisplayType* const type = DisplayTypeNamed(wanted.channel);
      if (type == nullptr || !type->schemas.empty()) throw Error(WhyNoDisplay(wanted.channel));
      Add(*type, "", {});
      entry = std::prev(entries.end());
    }
    ApplySettings(*entry, wanted.settings);
  }
}

void DisplayOpener::Restore(const Layout& layout) {
  keeps_show_found_ = layout.show_found;
  if (!layout.displays) return;
  show_found_ = layout.show_found;
  for (const LayoutDisplay& kept : *layout.displays) Restore(kept);
}

void DisplayOpener::Restore(const LayoutDisplay& kept) {
  const DisplayType* const type = DisplayTypeNamed(kept.kind);
  if (type == nullptr) {
    std::vector<std::string> kinds;
    for (const DisplayType& known : DisplayTypes()) kinds.push_back(known.name);
    throw ConfigError("There is no display \"" + kept.kind + "\".", kept.where, "There are " + JoinNames(kinds) + ".");
  }
  if (type->schemas.empty() != kept.channel.empty()) {
    throw ConfigError(
        "The display \"" + kept.kind + "\" " + (kept.channel.empty() ? "needs a" : "has no") + " channel.", kept.where,
        kept.channel.empty() ? "Write \"channel: NAME\" below its kind." : "Remove the channel.");
  }
  Scene::Entry* entry = nullptr;
  try {
    entry = &Open(*type, kept.channel);
  } catch (const Error& error) {
    throw ConfigError(error.what(), kept.where);
  }
  ApplySettings(*entry, kept);
  shown_.insert(kept.channel);
}

void DisplayOpener::AddPublished() {
  for (const ChannelRow& row : channels_.published()) {
    const DisplayType* const type = DisplayTypeFor(row.schema);
    const auto awaited = std::ranges::find(awaited_, row.name, &WantedDisplay::channel);
    if (awaited != awaited_.end()) {
      const WantedDisplay wanted = std::move(*awaited);
      awaited_.erase(awaited);
      if (type == nullptr) {
        notices_.ShowAndPrint("No display shows \"" + row.name + "\", which carries " + row.schema + ".");
      }
      if (type == nullptr || !TryAdd(*type, wanted)) request_failed_ = true;
    } else if (show_found_ && type != nullptr && shown_.size() < kMostFound && shown_.insert(row.name).second) {
      TryAdd(*type, {row.name, {}, {}});
    }
  }
}

std::size_t DisplayOpener::CountNotOpened() const {
  if (!show_found_ || shown_.size() < kMostFound) return 0;
  return static_cast<std::size_t>(std::ranges::count_if(channels_.published(), [this](const ChannelRow& row) {
    return DisplayTypeFor(row.schema) != nullptr && !shown_.contains(row.name) &&
           std::ranges::find(scene_.entries(), row.name, &Scene::Entry::channel) == scene_.entries().end();
  }));
}

// The publisher may appear long after the command line was read, so a mistake there does not end the program now.
bool DisplayOpener::TryAdd(const DisplayType& type, const WantedDisplay& wanted) {
  try {
    Add(type, wanted.channel, wanted.settings);
    return true;
  } catch (const Error& error) {
    notices_.ShowAndPrint(error.what());
    return false;
  }
}

void DisplayOpener::Add(const DisplayType& type, const std::string& channel,
                        const std::vector<std::pair<std::string, std::string>>& settings) {
  ApplySettings(Open(type, channel), settings);
}

Scene::Entry& DisplayOpener::Open(const DisplayType& type, const std::string& channel) {
  try {
    return scene_.Add(type, {session_, channel, wake_});
  } catch (const TypeMismatch&) {
    std::string carried = channels_.PublishedType(channel, type);
    const auto other = std::ranges::find(scene_.entries(), channel, &Scene::Entry::channel);
    if (carried.empty() && other != scene_.entries().end()) carried = other->type->schemas.front();
    const std::string why = WhyNotShown(type, channel, carried);
    throw Error(!why.empty() ? why
                             : "This viewer has already used \"" + channel +
                                   "\" with another type and cannot change it. Restart the viewer to show it as " +
                                   type.name + ".");
  }
}

std::string DisplayOpener::AddByHand(const DisplayType& type, const std::string& channel) {
  std::string refusal = WhyNotShown(type, channel, channels_.PublishedType(channel, type));
  try {
    if (refusal.empty()) Add(type, channel, {});
  } catch (const Error& error) {
    refusal = error.what();
  }
  return refusal;
}

void DisplayOpener::UpdateMismatches() {
  for (Scene::Entry& entry : scene_.entries()) {
    const std::string published = channels_.PublishedType(entry.channel, *entry.type);
    std::string mismatch = WhyNotShown(*entry.type, entry.channel, published);
    if (mismatch == entry.mismatch) continue;
    entry.mismatch = std::move(mismatch);
    if (!entry.mismatch.empty()) Notices::Print(entry.mismatch);
  }
}

void DisplayOpener::TakeOver(Carried carried) {
  shown_.merge(carried.found);
  keeps_show_found_ = carried.keeps_finding;
}

}  // namespace hgros::viewer
