#pragma once

#include <span>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/tf/edge_snapshot.hpp"

namespace hgros {

/// The tree as indented lines, one for each frame, with rate, age at `now` and publisher of the edge to its parent:
///
///     map
///       base     100.0 Hz, 0.012 s old, by localizer
///         laser  static, by robot
///
/// `edges` as TransformTree::Edges returns them.
[[nodiscard]] HGROS_EXPORT std::string DrawText(std::span<const EdgeSnapshot> edges, Time now);

/// The same for Graphviz: `dot -Tsvg tree.dot`.
[[nodiscard]] HGROS_EXPORT std::string DrawGraphviz(std::span<const EdgeSnapshot> edges, Time now);

/// The same as an SVG image: a box for each frame, with what is known about the edge to its parent below the name.
[[nodiscard]] HGROS_EXPORT std::string DrawSvg(std::span<const EdgeSnapshot> edges, Time now);

}  // namespace hgros
