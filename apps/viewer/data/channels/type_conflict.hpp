#pragma once

#include <string>

#include "hgros/bridge/known_channel.hpp"

namespace hgros::viewer {

/// If the users of a channel do not agree on its type: sentences with all types and programs. Otherwise empty.
[[nodiscard]] std::string TypeConflict(const KnownChannel& channel);

}  // namespace hgros::viewer
