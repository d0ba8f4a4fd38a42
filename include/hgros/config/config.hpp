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
#include "hgros/transport/shm_transport.hpp"

namespace hgros {

/// One endpoint of the network section with its white list.
struct EndpointConfig {
  /// "tcp://*:5553", "tcp://192.168.1.7:5553" or "ipc:///run/robot/bus", in the one spelling that equal endpoints
  /// share: always with a scheme, "*" for every address and for a port that the system chooses.
  std::string endpoint;
  std::vector<std::string> channels;  ///< Only these leave or enter here; sorted, without repeats.
  bool all_channels = false;          ///< The list is not there at all: every channel may pass.
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

/// What the configuration says of a channel that this session publishes or subscribes to.
struct ChannelConfig {
  std::optional<Queue> queue;          ///< Of every local subscription without an override of its own.
  std::optional<std::size_t> latched;  ///< The last N are kept for late subscribers.
  /// Between sessions it uses only these, sorted; of two sessions, only what both allow.
  TransportKeys transports = {};
  bool operator==(const ChannelConfig&) const = default;
};

/// How sessions find each other.
struct DiscoveryConfig {
  bool local = true;                   ///< On this host, by themselves.
  std::vector<std::string> only = {};  ///< On this host only these processes, by their sessions' names; empty: all.
  bool lan = false;                    ///< On other hosts of the same network, by a beacon.
  std::vector<std::string> lan_interfaces = {};  ///< The beacon's, by name; empty: all.
  /// Sessions of different domains do not find each other; "none": nobody is found. The environment variable
  /// HGROS_DOMAIN goes before it.
  std::string domain = "default";
  bool operator==(const DiscoveryConfig&) const = default;
};

/// How sessions of this host exchange messages.
struct SharedMemoryConfig {
  std::uint64_t limit_bytes = 256ULL * 1024 * 1024;  ///< For payloads, at most.
  ShmWait wait = ShmWait::kSleep;
  int spin_us = 50;  ///< With ShmWait::kSpin.
  bool operator==(const SharedMemoryConfig&) const = default;
};

/// Everything a session takes from YAML. docs/configuration.md lists the keys.
struct HGROS_EXPORT Config {
  std::vector<EndpointConfig> publishers;  ///< Sorted by endpoint, as the subscribers; those switched off are left out.
  std::vector<EndpointConfig> subscribers;
  SecurityConfig security;
  std::uint64_t peer_queue_bytes = 64ULL * 1024 * 1024;  ///< Waiting for one slow remote subscriber at most.
  DiscoveryConfig discovery;
  SharedMemoryConfig shared_memory;
  int heartbeat_ms = 1000;
  int peer_timeout_ms = 5000;  ///< A peer silent for longer is gone.

  bool simulated_time = false;  ///< The session's clock follows the channel "clock".

  std::vector<std::string> closed_channels;  ///< Not delivered to this process' own nodes.
  int threads = 0;                           ///< Workers of the tbb executor; 0: one less than there are CPUs.
  NodeOverrides nodes;
  std::map<std::string, ChannelConfig, std::less<>> channels;

  /// Reads and merges files. The same publisher endpoint in several files is one endpoint with the union of the
  /// channels; other lists are joined too, and single values must agree, so that the order of the files does not
  /// matter. Throws ConfigError naming file, line, column, and the nearest known key or value.
  /// `program_sections` are top-level keys that the program reads itself; what they hold is not looked at here.
  [[nodiscard]] static Config Load(std::span<const std::filesystem::path> files,
                                   std::span<const std::string> program_sections = {});
  [[nodiscard]] static Config Load(std::initializer_list<std::filesystem::path> files);
  [[nodiscard]] static Config Load(const std::filesystem::path& file);
  /// Likewise from a text; `name` stands for the file in errors.
  [[nodiscard]] static Config Parse(std::string_view yaml, std::string_view name = "configuration");
};

}  // namespace hgros
