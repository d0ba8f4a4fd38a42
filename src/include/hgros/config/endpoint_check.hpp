#pragma once

#include <cstdint>
#include <string_view>

namespace hgros {

enum class EndpointSide : std::uint8_t { kPublisher, kSubscriber };

/// Throws Error if a configuration file could not have this endpoint, or if it is "x", with the sentence of such a
/// file.
void RequireEndpoint(std::string_view endpoint, EndpointSide side);

}  // namespace hgros
