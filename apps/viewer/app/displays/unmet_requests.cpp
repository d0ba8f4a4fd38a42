#include "viewer/app/displays/unmet_requests.hpp"

#include <algorithm>
#include <vector>

#include "hgros/base/names.hpp"
#include "viewer/app/notices.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/panels/view_panel.hpp"

namespace hgros::viewer {
namespace {

/// " Did you mean "map"?" if one of the names is similar.
std::string Suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = name.size() <= 64 ? NearestName(name, known) : std::string();
  return nearest.empty() || nearest == name ? std::string() : " Did you mean \"" + nearest + "\"?";
}

bool ShowsNothing(const Display& display) { return display.Bounds().isEmpty() && !display.Image(); }

// Without any transforms, messages may name the fixed frame. Entities name several frames; if they could be placed, the
// fixed frame is known.
bool IsFixedFrameKnown(const RequestState& state, const std::vector<std::string>& frames) {
  const std::string& fixed = state.frame.name();
  return std::ranges::find(frames, fixed) != frames.end() ||
         std::ranges::any_of(state.scene.entries(), [&](const Scene::Entry& entry) {
           const std::string frame = entry.display->data_frame();
           const bool placed = !entry.display->HasFault() && entry.display->WaitsFor().empty();
           return frame == fixed || (frame.empty() && entry.display->received() > 0 && placed);
         });
}

std::string NeverPublished(const std::string& channel, const ChannelList& channels) {
  std::vector<std::string> published;
  for (const ChannelRow& row : channels.published()) published.push_back(row.name);
  return "The channel \"" + channel + "\" was never published." + Suggestion(channel, published);
}

/// Returns whether the requested display shows nothing, and prints why.
bool PrintUnmetDisplay(const Scene::Entry& entry, bool requested, const RequestState& state) {
  const ChannelList& channels = state.channels;
  if (entry.display->HasFault()) {
    Notices::Print(entry.name + ": " + entry.display->Status().front());
    return ShowsNothing(*entry.display);
  }
  if (const std::string why = entry.display->WaitsFor(); !why.empty() && ShowsNothing(*entry.display)) {
    Notices::Print(entry.name + ": " + why);
    return true;
  }
  if (!requested) return false;
  if (entry.display->received() > 0) {
    const std::vector<std::string> status = entry.display->Status();
    if (state.options.offscreen && ShowsNothing(*entry.display) && !status.empty()) {
      Notices::Print(entry.name + ": " + status.front());
    }
    return false;
  }
  const auto row = std::ranges::find(channels.published(), entry.channel, &ChannelRow::name);
  if (row == channels.published().end()) {
    Notices::Print(NeverPublished(entry.channel, channels));
  } else if (row->conflict.empty()) {
    Notices::Print("No message came on the channel \"" + entry.channel + "\" that could be shown.");
  } else {
    Notices::Print("Nothing of the channel \"" + entry.channel + "\" could be shown. " + row->conflict);
  }
  return true;
}

bool PrintUnmetFrames(const RequestState& state) {
  bool unmet = false;
  const std::vector<std::string> frames = FrameNames(state.frame.tree());
  const std::string& fixed = state.frame.name();
  if (!state.frame.chosen() && !IsFixedFrameKnown(state, frames)) {
    Notices::Print("The fixed frame \"" + fixed + "\" was never found." + Suggestion(fixed, frames));
    unmet = true;
  }
  RigidTransform T_fixed_frame;
  std::string why;
  if (state.frame.Find(state.followed, T_fixed_frame, why) != FixedFrame::Answer::kFound) {
    Notices::Print("The frame \"" + state.followed + "\", which the camera should follow, was never found." +
                   Suggestion(state.followed, frames));
    unmet = true;
  }
  return unmet;
}

}  // namespace

bool PrintUnmetRequests(const RequestState& state) {
  bool unmet = state.displays.request_failed();
  for (const WantedDisplay& wanted : state.displays.awaited()) {
    Notices::Print(NeverPublished(wanted.channel, state.channels));
    unmet = true;
  }
  for (const Scene::Entry& entry : state.scene.entries()) {
    const bool requested =
        std::ranges::find(state.options.channels, entry.name, &WantedDisplay::channel) != state.options.channels.end();
    if (requested || entry.type == DisplayTypeNamed("Robot model")) {
      unmet |= PrintUnmetDisplay(entry, requested, state);
    } else if (state.options.offscreen && entry.visible && !entry.channel.empty()) {
      (void)PrintUnmetDisplay(entry, true, state);  // It was found, and nobody sees its row.
    }
  }
  if (const std::size_t more = state.displays.CountNotOpened(); state.options.offscreen && more > 0) {
    Notices::Print(Counted(more, "more channel was", "more channels were") + " found and not opened: at most " +
                   std::to_string(DisplayOpener::kMostFound) + " are shown without --channel.");
  }
  unmet |= PrintUnmetFrames(state);
  return unmet;
}

}  // namespace hgros::viewer
