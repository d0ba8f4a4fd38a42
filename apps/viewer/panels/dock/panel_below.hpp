#pragma once

namespace hgros::viewer {

/// Whether there is a panel that takes the mouse at a place, in ImGui's coordinates. ImGui itself knows this only for
/// the pointer of the last picture, which may be old with software rendering.
[[nodiscard]] bool PanelBelow(float x, float y);

}  // namespace hgros::viewer
