#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "support/free_port.hpp"
#include "support/relay_port.hpp"

namespace hgros::resilience {

/// A folder for ipc endpoints, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "hgros_resilience_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder");
    path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string Endpoint(const std::string& name) const { return "ipc://" + (path_ / name).string(); }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

using test::FreePort;
using test::LoopbackAddress;

inline std::string TcpEndpoint(std::uint16_t port) { return "tcp://127.0.0.1:" + std::to_string(port); }

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
