#pragma once

#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/session/default_session.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros {

/// The default session's transforms, from the first use until Shutdown.
/// Errors: throws Error if there is no default session.
[[nodiscard]] HGROS_EXPORT Transforms& DefaultTransforms();

/// The paper's interface: sets the pose of `child` in `parent`; gets the latest one.
template <class T>
SetResult ToTF(Time stamp, std::string_view parent, std::string_view child, const T& T_parent_child) {
  return DefaultTransforms().ToTF(stamp, parent, child, T_parent_child);
}
[[nodiscard]] inline TransformResult FromTF(std::string_view parent, std::string_view child) {
  return DefaultTransforms().FromTF(parent, child);
}
[[nodiscard]] inline TransformResult FromTF(std::string_view parent, std::string_view child, Time time) {
  return DefaultTransforms().FromTF(parent, child, time);
}

}  // namespace hgros
