#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

#include "hgros/base/ids.hpp"
#include "support/free_port.hpp"
#include "support/relay_port.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::resilience {

using test::FreePort;
using test::LoopbackAddress;
using test::ScratchFolder;

inline std::string TcpEndpoint(std::uint16_t port) { return "tcp://127.0.0.1:" + std::to_string(port); }

/// Sessions that begin while it lives find each other.
class OwnDomain {
 public:
  OwnDomain() { setenv("HGROS_DOMAIN", name.c_str(), 1); }
  OwnDomain(const OwnDomain&) = delete;
  OwnDomain& operator=(const OwnDomain&) = delete;
  ~OwnDomain() { setenv("HGROS_DOMAIN", "none", 1); }
  const std::string name = "test-" + SessionId::Random().ToString();
};

/// "--config=" with the network section; `more` contains further keys of this section, such as ", heartbeat_ms: 100".
inline std::string Publishing(const std::string& endpoint, const std::string& more = {}) {
  return "--config=network: {publisher: {ip: \"" + endpoint + "\"}" + more + "}";
}
inline std::string Subscribing(const std::string& endpoint, const std::string& more = {}) {
  return "--config=network: {subscribers: [{ip: \"" + endpoint + "\"}]" + more + "}";
}
inline std::string Both(const std::string& publish, const std::string& subscribe, const std::string& more = {}) {
  return "--config=network: {publisher: {ip: \"" + publish + "\"}, subscribers: [{ip: \"" + subscribe + "\"}]" + more +
         "}";
}

/// Settings with which silent peers are dropped soon, but none whose threads a busy machine does not run for a second.
inline constexpr const char* kImpatient = ", heartbeat_ms: 100, peer_timeout_ms: 2000";

}  // namespace hgros::resilience
