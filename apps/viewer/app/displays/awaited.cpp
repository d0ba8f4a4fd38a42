#include "viewer/app/displays/awaited.hpp"

#include <algorithm>
#include <cstdlib>

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostNamed = 5;

std::string Named(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) {
    list += (i == 0 ? "\"" : ", \"") + names[i] + "\"";
  }
  if (names.size() > kMostNamed) list += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return list;
}

}  // namespace

std::string ReachText(const Config& config) {
  const char* const set = std::getenv("HGROS_DOMAIN");
  const std::string domain = set != nullptr && *set != '\0' ? set : config.discovery.domain;
  const auto& discovery = config.discovery;
  if (domain == "none" || (!discovery.local && !discovery.lan)) {
    return "Discovery is off: the viewer reaches only the endpoints of its network file (--network).";
  }
  const char* const where = !discovery.lan    ? "on this host"
                            : discovery.local ? "on this host and its networks"
                                              : "on the networks of this host";
  return "The viewer finds programs of the domain \"" + domain + "\" " + where +
         ". HGROS_DOMAIN sets another domain, --network FILE reaches other hosts.";
}

std::string AwaitedText(const Scene& scene, const PanelDock& dock, const ChannelList& channels,
                        const DisplayOpener& displays, const FixedFrame& frame) {
  if (dock.HasReceived()) return {};
  std::vector<std::string> names;
  for (const WantedDisplay& wanted : displays.awaited()) names.push_back(wanted.channel);
  for (const Scene::Entry& entry : scene.entries()) {
    if (entry.display->received() > 0) return {};
    if (!entry.channel.empty()) names.push_back(entry.channel);
    if (!entry.display->Bounds().isEmpty()) return {};  // A robot model needs no message.
  }
  if (!frame.tree().Edges().empty()) return {};
  if (!names.empty()) {
    return std::string("Waiting for the ") + (names.size() == 1 ? "channel " : "channels ") + Named(names) + ".";
  }
  if (channels.published().empty()) return "Waiting for a program that publishes something.";
  std::vector<std::string> published;
  for (const ChannelRow& row : channels.published()) published.push_back(row.name);
  return "No display shows what is published: " + Named(published) + ". Try the panels Message, Plot and Log.";
}

}  // namespace hgros::viewer
