#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hgros/config/config.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

// The channels that may pass an endpoint, in the form that transports use.
[[nodiscard]] ChannelList ListOf(const EndpointConfig& endpoint);

// Adds the channel to the list or removes it. False if the endpoint lets all channels pass and `allowed` is true.
// Throws Error if the channel is to be removed from such an endpoint: there is no list to remove it from.
bool SetAllowed(EndpointConfig& endpoint, std::string_view channel, bool allowed);

// The boundary that a channel does not cross if no endpoint lets it pass: "host" or "process". `has_domain`: the
// session can be discovered.
[[nodiscard]] std::string_view OutermostPlace(const Config& config, bool has_domain) noexcept;

enum class Way { kOut, kIn };

// A sentence for a channel that no endpoint lets pass. Empty if an endpoint lets it pass, or if there are no endpoints.
// Without it a wrong name in an endpoint's list would only cause silence. `place`: the boundary, such as "host".
[[nodiscard]] std::string DescribeConfined(std::string_view channel, const std::vector<EndpointConfig>& endpoints,
                                           Way way, std::string_view place);

}  // namespace hgros
