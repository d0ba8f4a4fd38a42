#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "viewer/app/layout.hpp"
#include "viewer/app/options.hpp"
#include "viewer/app/surface.hpp"

namespace hgros::viewer {

class Viewer;

/// Runs viewers, one after the other: a surface that was lost is made anew, and the next viewer shows what the last one
/// did, but for the messages that it had. After some losses in a row it gives up and says so.
///
/// `watch` is told of each viewer before it runs, and null behind it, also when it ends by an Error. Returns the exit
/// code.
[[nodiscard]] int ShowUntilClosed(Options options, std::optional<Layout> layout,
                                  const std::function<std::unique_ptr<Surface>()>& make_surface,
                                  const std::function<void(Viewer* viewer)>& watch);

}  // namespace hgros::viewer
