#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/transport/shm_wait.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros {

/// One endpoint of the network section with its list of channels.
struct EndpointConfig {
  /// "tcp://*:5553", "tcp://192.168.1.7:5553" or "ipc:///run/robot/bus". Normalized, so that equal endpoints have equal
  /// texts: always with a scheme; "*" means every address, or a port that the system chooses.
  std::string endpoint;
  std::vector<std::string> channels;  ///< Only these may pass; sorted, without repeats.
  bool all_channels = false;          ///< There is no list: every channel may pass.
  bool operator==(const EndpointConfig&) const = default;
};

/// CURVE keys as the 40 characters of Z85. Empty: no encryption.
struct SecurityConfig {
  std::string public_key;
  std::string secret_key;
  std::vector<std::string> allowed_clients;                 ///< Public keys that may connect to us.
  std::map<std::string, std::string, std::less<>> servers;  ///< Public key of each subscriber endpoint.
  [[nodiscard]] bool enabled() const noexcept { return !secret_key.empty(); }
  bool operator==(const SecurityConfig&) const = default;
};

/// The configuration of a channel that this session publishes or subscribes to.
struct ChannelConfig {
  std::optional<Queue> queue;          ///< For every local subscription without its own override.
  std::optional<std::size_t> latched;  ///< Number of recent messages kept for late subscribers.
  /// Transports between sessions, sorted. Two sessions use only those that both allow.
  TransportKeys transports = {};
  bool operator==(const ChannelConfig&) const = default;
};

/// How sessions find each other.
struct DiscoveryConfig {
  bool local = true;                             ///< Finds sessions on this host.
  std::vector<std::string> only = {};            ///< Names of the only sessions of this host to find; empty: all.
  bool lan = false;                              ///< Finds sessions on other hosts of the same network, by a beacon.
  std::vector<std::string> lan_interfaces = {};  ///< Names of the beacon's network interfaces; empty: all.
  /// Sessions of different domains do not find each other; "none": no session is found. The environment variable
  /// HGROS_DOMAIN overrides it.
  std::string domain = "default";
  bool operator==(const DiscoveryConfig&) const = default;
};

/// How sessions of this host exchange messages.
struct SharedMemoryConfig {
  std::uint64_t limit_bytes = 256ULL * 1024 * 1024;  ///< Maximum for payloads.
  ShmWait wait = ShmWait::kSleep;
  int spin_us = 50;  ///< With ShmWait::kSpin.
  bool operator==(const SharedMemoryConfig&) const = default;
};

/// Everything a session takes from YAML. docs/configuration.md lists the keys.
struct HGROS_EXPORT Config {
  /// Both lists are sorted by endpoint, without endpoints that are switched off.
  std::vector<EndpointConfig> publishers;
  std::vector<EndpointConfig> subscribers;
  SecurityConfig security;
  std::uint64_t peer_queue_bytes = 64ULL * 1024 * 1024;  ///< Maximum that waits for one slow remote subscriber.
  DiscoveryConfig discovery;
  SharedMemoryConfig shared_memory;
  int heartbeat_ms = 1000;
  int peer_timeout_ms = 5000;  ///< A peer that is silent for longer is gone.

  bool control = true;          ///< Others of the same user, or with an allowed key, may steer it: `hgros control`.
  bool simulated_time = false;  ///< The session's clock follows the channel "clock" (ClockPublisher).

  std::vector<std::string> closed_channels;  ///< Not delivered to this process' own nodes.
  int threads = 0;                           ///< Workers of the tbb executor; 0: one less than the number of CPUs.
  NodeOverrides nodes;
  std::map<std::string, ChannelConfig, std::less<>> channels;

  /// Reads and merges files. Their order does not matter: the same publisher endpoint in several files becomes one
  /// endpoint with the channels of all, other lists are joined too, and single values must agree. Throws ConfigError
  /// naming file, line, column, and the nearest known key or value. `program_sections` are top-level keys that the
  /// program reads itself; their contents are ignored here.
  [[nodiscard]] static Config Load(std::span<const std::filesystem::path> files,
                                   std::span<const std::string> program_sections = {});
  [[nodiscard]] static Config Load(std::initializer_list<std::filesystem::path> files);
  [[nodiscard]] static Config Load(const std::filesystem::path& file);
  /// The same from a text. Errors show `name` as the file.
  [[nodiscard]] static Config Parse(std::string_view yaml, std::string_view name = "configuration");
  /// The same from a document.
  [[nodiscard]] static Config From(const yaml::Document& document, std::span<const std::string> program_sections = {});
  /// What the environment variable HGROS_CONFIG holds, as YAML; the default if it is not set or empty. For a session
  /// whose program gives no configuration.
  [[nodiscard]] static Config OfEnvironment();
};

}  // namespace hgros
