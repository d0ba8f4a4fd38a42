#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hgros/config/endpoint_check.hpp"
#include "hgros/yaml/reader.hpp"

namespace hgros {

/// An endpoint in its canonical spelling, so that equal endpoints have equal texts. ZeroMQ accepts it: scheme and
/// address in lower case, no leading zeros, "*" for every address and for a port that the system chooses.
struct Endpoint {
  std::string text;
  std::optional<int> tcp_port;  ///< Absent for ipc and for a port that the system chooses.
};

/// Reads an endpoint. Empty if it is switched off ("x"). Throws ConfigError at `value` for anything else.
[[nodiscard]] std::optional<Endpoint> ReadEndpoint(const yaml::Value& value, EndpointSide side);
/// Reads an endpoint from `text`, such as a map key. Errors are reported at `value`.
[[nodiscard]] std::optional<Endpoint> ReadEndpoint(std::string_view text, const yaml::Value& value, EndpointSide side);

}  // namespace hgros
