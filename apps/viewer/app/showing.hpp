#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "viewer/app/layout/layout.hpp"
#include "viewer/app/options.hpp"
#include "viewer/app/surface/surface.hpp"

namespace hgros::viewer {

class Viewer;

/// Runs viewers one after another. When a surface is lost, a new one is made, and the next viewer shows the same as the
/// last one, except for its messages. After several losses in a row it gives up with an error.
///
/// `watch` gets each viewer before it runs, and null after it, also if it ends with an Error. Returns the exit code.
[[nodiscard]] int ShowUntilClosed(Options options, std::optional<Layout> layout,
                                  const std::function<std::unique_ptr<Surface>()>& make_surface,
                                  const std::function<void(Viewer* viewer)>& watch);

}  // namespace hgros::viewer
