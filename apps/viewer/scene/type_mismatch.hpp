#pragma once

#include <string>

#include "viewer/scene/display_types.hpp"

namespace hgros::viewer {

/// Why a display of that type cannot show a channel with the type `carried`, as a sentence. Empty if it can, or if
/// `carried` is empty (unknown).
[[nodiscard]] std::string WhyNotShown(const DisplayType& type, const std::string& channel, const std::string& carried);

}  // namespace hgros::viewer
