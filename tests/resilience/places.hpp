#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

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

using test::LoopbackAddress;

/// A free port of the loopback, below those that the system gives to outgoing connections. A program that repeatedly
/// connects to a port of that range could get the same port for its own end, and so be connected to itself.
inline std::uint16_t FreePort() {
  static int next = getpid() % 18000 * 37;
  for (int tries = 0; tries < 1000; ++tries) {
    const auto port = static_cast<std::uint16_t>(12000 + next++ % 18000);
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = LoopbackAddress(port);
    const bool free = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(fd);
    if (free) return port;
  }
  throw std::runtime_error("no free port");
}

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

/// Settings with which silent peers are dropped soon.
inline constexpr const char* kImpatient = ", heartbeat_ms: 100, peer_timeout_ms: 500";

}  // namespace hgros::resilience
