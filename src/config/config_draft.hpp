#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/config/config.hpp"
#include "hgros/yaml/reader.hpp"

namespace hgros {

/// The settings read so far. A setting that a later file may contradict has its position.
struct ConfigDraft {
  template <typename T>
  using Maybe = std::optional<yaml::Setting<T>>;

  struct Endpoint {
    FilePosition position;  ///< Where it appears first.
    std::optional<int> tcp_port;
    std::set<std::string> channels;
    bool all_channels = false;
  };
  struct Node {
    Maybe<Queue> queue;
    Maybe<Executor> executor;
  };
  struct Channel {
    Maybe<Queue> queue;
    Maybe<std::size_t> latched;
    Maybe<std::vector<std::string>> transports;
  };
  /// A switch that may be a list of names instead: then it is on for these names.
  struct NamedSwitch {
    bool on = false;
    std::vector<std::string> names;
    bool operator==(const NamedSwitch&) const = default;
  };

  yaml::Faults faults;         ///< For the checks of settings against each other.
  bool read_key_files = true;  ///< Otherwise a key file counts as a key that is not known.

  std::map<std::string, Endpoint> publishers;  ///< By endpoint, like the subscribers.
  std::map<std::string, Endpoint> subscribers;
  Maybe<std::uint64_t> peer_queue_bytes;
  Maybe<int> heartbeat_ms;
  Maybe<int> peer_timeout_ms;

  Maybe<NamedSwitch> discovery_local;
  Maybe<NamedSwitch> discovery_lan;
  Maybe<std::string> domain;
  Maybe<std::uint64_t> shared_memory_limit_bytes;
  Maybe<ShmWait> shared_memory_wait;
  Maybe<int> shared_memory_spin_us;

  Maybe<std::string> public_key;
  Maybe<std::string> secret_key;
  std::map<std::string, FilePosition> allowed_clients;  ///< By key.
  std::map<std::string, yaml::Setting<std::string>> servers;

  Maybe<bool> simulated_time;
  Maybe<bool> control;
  std::set<std::string> closed_channels;
  Maybe<int> threads;
  std::map<std::string, Node> nodes;
  std::map<std::string, Channel> channels;

  /// Checks the settings against each other. Reports ConfigErrors.
  [[nodiscard]] Config Finish() const;
};

/// Each function reads one section into the draft. Reports ConfigErrors, and throws them if nothing can be read.
void ReadNetwork(const yaml::Value& section, ConfigDraft& draft);
void ReadSecurity(const yaml::Value& section, ConfigDraft& draft);
void ReadDiscovery(const yaml::Value& section, ConfigDraft& draft);
void ReadSharedMemory(const yaml::Value& section, ConfigDraft& draft);
void ReadDataGraph(const yaml::Value& section, ConfigDraft& draft);
void ReadChannels(const yaml::Value& section, ConfigDraft& draft);

/// Reports settings that have no effect together with others.
void CheckHost(const ConfigDraft& draft);
/// Reports if encryption is on or partly configured, but could not protect every connection.
void CheckSecurity(const ConfigDraft& draft);

/// Reads a list of distinct channel names. Reports ConfigErrors.
[[nodiscard]] std::set<std::string> ReadChannelNames(const yaml::Value& list);
/// Throws ConfigError if `name`, which is at `position`, is not a channel name.
void CheckChannelName(const std::string& name, const FilePosition& position);

}  // namespace hgros
