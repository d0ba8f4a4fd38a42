#pragma once

#include <span>

#include "viewer/panels/dock/panel_place.hpp"

namespace hgros::viewer {

/// The largest rectangle of `all` that none of `taken` covers. All of it if less than a tenth is free.
[[nodiscard]] PanelPlace LargestFree(const PanelPlace& all, std::span<const PanelPlace> taken);

/// The largest part of the window that no panel covered in the last frame.
[[nodiscard]] PanelPlace FreeRoom();

}  // namespace hgros::viewer
