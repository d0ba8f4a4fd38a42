#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/yaml/reader.hpp"

namespace hgros {

enum class EndpointSide : std::uint8_t { kPublisher, kSubscriber };

/// An endpoint in the one spelling that ZeroMQ takes and that equal endpoints share: scheme and address in lower
/// case, no leading zeros, "*" for every address and for a port that the system chooses.
struct Endpoint {
  std::string text;
  std::optional<int> tcp_port;  ///< Absent for ipc and for a port that the system chooses.
};

/// Reads an endpoint; nothing if it is switched off ("x"). Throws ConfigError at `value` for anything else.
[[nodiscard]] std::optional<Endpoint> ReadEndpoint(const yaml::Value& value, EndpointSide side);
/// Likewise from a `text` that stands at `value` otherwise than as its content, such as a key.
[[nodiscard]] std::optional<Endpoint> ReadEndpoint(std::string_view text, const yaml::Value& value, EndpointSide side);

}  // namespace hgros
