#pragma once

namespace hgros::viewer {

/// Whether a panel that takes the mouse lies at a place, in ImGui's coordinates. ImGui itself says that only of where
/// the pointer was in the last picture, and with software rendering that may be a while ago.
[[nodiscard]] bool PanelBelow(float x, float y);

}  // namespace hgros::viewer
