#pragma once

#include <string>

#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/displays/display_opener.hpp"
#include "viewer/app/options.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// What PrintUnmetRequests looks at.
struct RequestState {
  const Options& options;
  const Scene& scene;
  const ChannelList& channels;
  const DisplayOpener& displays;
  const FixedFrame& frame;
  const std::string& followed;  ///< The frame that the camera follows; empty: none.
};

/// Prints what was asked for by name and is not there at the end. Returns whether there is any.
[[nodiscard]] bool PrintUnmetRequests(const RequestState& state);

}  // namespace hgros::viewer
