#pragma once

#include <string>
#include <vector>

#include "hgros/config/config.hpp"
#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/displays/display_opener.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/panels/dock/panel_dock.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Which programs a session with that configuration finds, as a sentence that names its domain.
[[nodiscard]] std::string ReachText(const Config& config);

/// As long as nothing at all has arrived: what a viewer waits for, or that no display shows what is published, as a
/// sentence. Empty afterwards.
[[nodiscard]] std::string AwaitedText(const Scene& scene, const PanelDock& dock, const ChannelList& channels,
                                      const DisplayOpener& displays, const FixedFrame& frame);

}  // namespace hgros::viewer
