#pragma once

#include <string>

#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/displays/display_opener.hpp"
#include "viewer/app/options.hpp"
#include "viewer/data/frames/fixed_frame.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// The state that PrintUnmetRequests checks.
struct RequestState {
  const Options& options;
  const Scene& scene;
  const ChannelList& channels;
  const DisplayOpener& displays;
  const FixedFrame& frame;
  const std::string& followed;  ///< The frame that the camera follows; empty: none.
};

/// Prints what was requested by name and is missing at the end, and with --offscreen also what was found and could not
/// be shown. Returns whether anything requested is missing.
[[nodiscard]] bool PrintUnmetRequests(const RequestState& state);

}  // namespace hgros::viewer
