#pragma once

#include <string>

#include "viewer/scene/display_types.hpp"

namespace hgros::viewer {

/// Why a display of that type shows nothing of a channel that carries `carried`, in a sentence; empty if it does, or if
/// that is unknown (empty).
[[nodiscard]] std::string WhyNotShown(const DisplayType& type, const std::string& channel, const std::string& carried);

}  // namespace hgros::viewer
