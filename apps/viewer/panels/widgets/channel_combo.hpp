#pragma once

#include <span>
#include <string>

#include "hgros/bridge/known_channel.hpp"

namespace hgros::viewer {

/// Draws a list for choosing a channel. Returns whether another one was chosen.
bool DrawChannelCombo(const char* label, std::string& channel, std::span<const KnownChannel> channels);

}  // namespace hgros::viewer
