#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hgros/config/config.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

// The channels that may pass an endpoint, as transports take them.
[[nodiscard]] ChannelList ListOf(const EndpointConfig& endpoint);

// Adds the channel to the list or takes it out. False if the endpoint lets the channel pass already. Throws Error for
// taking a channel from an endpoint that lets all pass: a list without it cannot be written down.
bool SetAllowed(EndpointConfig& endpoint, std::string_view channel, bool allowed);

// What a channel that no endpoint lets pass does not leave: "host" or "process". `has_domain`: the session can be
// found.
[[nodiscard]] std::string_view OutermostPlace(const Config& config, bool has_domain) noexcept;

enum class Way { kOut, kIn };

// A wrong name in a white list would otherwise only cause silence. A sentence, or nothing if the channel may pass one
// of the endpoints, or there is none. `place`: what the channel does not leave or enter, such as "host".
[[nodiscard]] std::string DescribeConfined(std::string_view channel, const std::vector<EndpointConfig>& endpoints,
                                           Way way, std::string_view place);

}  // namespace hgros
