#pragma once

#include <span>
#include <string>

#include "hgros/session/known_channel.hpp"

namespace hgros::viewer {

/// A list to choose one of the channels from; whether another one was chosen.
bool DrawChannelCombo(const char* label, std::string& channel, std::span<const KnownChannel> channels);

}  // namespace hgros::viewer
