#pragma once

#include <string>

#include "hgros/session/known_channel.hpp"

namespace hgros::viewer {

/// Who uses a channel with which type, in sentences, if that is not one and the same; else empty.
[[nodiscard]] std::string TypeConflict(const KnownChannel& channel);

}  // namespace hgros::viewer
