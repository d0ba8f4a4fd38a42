#pragma once

#include <string>
#include <vector>

#include "hgros/config/config.hpp"
#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/displays/display_opener.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Which programs a session with that configuration finds, as a sentence that names its domain.
[[nodiscard]] std::string ReachText(const Config& config);

/// What a viewer waits for, as a sentence, as long as nothing at all has arrived. Empty afterwards.
[[nodiscard]] std::string AwaitedText(const Scene& scene, const ChannelList& channels, const DisplayOpener& displays,
                                      const FixedFrame& frame);

}  // namespace hgros::viewer
