#include <algorithm>
#include <cstdio>

#include "hgros/base/names.hpp"
#include "viewer/app/viewer.hpp"

namespace hgros::viewer {
namespace {

/// " Did you mean "map"?", if one of the names is much like it.
std::string Suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = name.size() <= 64 ? NearestName(name, known) : std::string();
  return nearest.empty() || nearest == name ? std::string() : " Did you mean \"" + nearest + "\"?";
}

bool ShowsNothing(const Display& display) { return display.Bounds().isEmpty() && !display.Image(); }

}  // namespace

void Viewer::SayWhatIsUnmet() {
  const auto say = [](const std::string& sentence) { std::fprintf(stderr, "hgros-viewer: %s\n", sentence.c_str()); };
  const auto lacks = [&](const std::string& sentence) {
    say(sentence);
    unmet_ = true;
  };
  std::vector<std::string> published;
  for (const ChannelRow& row : channels_) published.push_back(row.name);
  const auto never = [&](const std::string& channel) {
    lacks("The channel \"" + channel + "\" never came." + Suggestion(channel, published));
  };
  for (const WantedDisplay& wanted : awaited_) never(wanted.channel);
  for (const Scene::Entry& entry : scene_.entries()) {
    const bool asked =
        std::ranges::find(options_.channels, entry.name, &WantedDisplay::channel) != options_.channels.end();
    if (!asked && entry.type != DisplayTypeNamed("Robot model")) continue;
    if (entry.display->HasFault()) {
      const std::string sentence = entry.name + ": " + entry.display->Status().front();
      ShowsNothing(*entry.display) ? lacks(sentence) : say(sentence);
    } else if (asked && entry.display->received() == 0) {
      const auto row = std::ranges::find(channels_, entry.channel, &ChannelRow::name);
      if (row == channels_.end()) {
        never(entry.channel);
      } else if (row->conflict.empty()) {
        lacks("No message came on the channel \"" + entry.channel + "\" that could be shown.");
      } else {
        lacks("Nothing of the channel \"" + entry.channel + "\" could be shown. " + row->conflict);
      }
    }
  }
  const std::vector<std::string> frames = FrameNames(frame_.tree());
  RigidTransform T_fixed_frame;
  std::string why;
  if (!frame_.chosen() && !IsFixedFrameKnown(frames)) {
    lacks("The fixed frame \"" + frame_.name() + "\" never came." + Suggestion(frame_.name(), frames));
  }
  if (frame_.Find(view_panel_.follow(), T_fixed_frame, why) != FixedFrame::Answer::kFound) {
    lacks("The frame \"" + view_panel_.follow() + "\", which the camera was to follow, never came." +
          Suggestion(view_panel_.follow(), frames));
  }
  if (unmet_ && options_.offscreen) exit_code_ = 1;
}

// Without any transforms messages may name it; those of entities name several, and are shown if they could be placed.
bool Viewer::IsFixedFrameKnown(const std::vector<std::string>& frames) const {
  return std::ranges::find(frames, frame_.name()) != frames.end() ||
         std::ranges::any_of(scene_.entries(), [&](const Scene::Entry& entry) {
           const std::string frame = entry.display->data_frame();
           return frame == frame_.name() ||
                  (frame.empty() && entry.display->received() > 0 && !entry.display->HasFault());
         });
}

}  // namespace hgros::viewer
