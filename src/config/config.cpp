#include "hgros/config/config.hpp"

#include <cstdlib>

#include "config/config_draft.hpp"
#include "hgros/config/check.hpp"
#include "hgros/config/config_sections.hpp"

namespace hgros {
namespace {

// "a map with network, discovery and time".
std::string MapOfSections() {
  std::string text = "a map with ";
  for (std::size_t i = 0; i < kConfigSections.size(); ++i) {
    if (i > 0) text += i + 1 == kConfigSections.size() ? " and " : ", ";
    text += kConfigSections[i];
  }
  return text;
}

void ReadFile(const yaml::Document& document, std::span<const std::string> program_sections, ConfigDraft& draft) {
  std::vector<std::string_view> known(kConfigSections.begin(), kConfigSections.end());
  known.insert(known.end(), program_sections.begin(), program_sections.end());
  const yaml::Section file(yaml::Value(document, draft.faults), MapOfSections(), known);
  file.Read("network", [&](const yaml::Value& network) { ReadNetwork(network, draft); });
  file.Read("discovery", [&](const yaml::Value& discovery) { ReadDiscovery(discovery, draft); });
  file.Read("shared_memory", [&](const yaml::Value& memory) { ReadSharedMemory(memory, draft); });
  file.Read("time", [&](const yaml::Value& time) {
    yaml::Settle(draft.simulated_time, time.Choice({"system", "simulated"}) == 1, time);
  });
  file.Read("control", [&](const yaml::Value& control) {
    yaml::Settle(draft.control, control.Choice({"off", "on"}) == 1, control);
  });
  file.Read("data_graph", [&](const yaml::Value& data_graph) { ReadDataGraph(data_graph, draft); });
  file.Read("channels", [&](const yaml::Value& channels) { ReadChannels(channels, draft); });
}

std::vector<EndpointConfig> WhiteLists(const std::map<std::string, ConfigDraft::Endpoint>& endpoints) {
  std::vector<EndpointConfig> out;
  for (const auto& [text, endpoint] : endpoints) {
    EndpointConfig& config = out.emplace_back();
    config.endpoint = text;
    config.all_channels = endpoint.all_channels;
    if (!endpoint.all_channels) config.channels.assign(endpoint.channels.begin(), endpoint.channels.end());
  }
  return out;
}

template <typename T>
std::optional<T> ValueOf(const std::optional<yaml::Setting<T>>& setting) {
  return setting ? std::optional<T>(setting->value) : std::nullopt;
}

template <typename T>
void Apply(const std::optional<yaml::Setting<T>>& setting, T& target) {
  if (setting) target = setting->value;
}

}  // namespace

Config ConfigDraft::Finish() const {
  CheckSecurity(*this);
  CheckHost(*this);
  Config config;
  config.publishers = WhiteLists(publishers);
  config.subscribers = WhiteLists(subscribers);
  Apply(public_key, config.security.public_key);
  Apply(secret_key, config.security.secret_key);
  for (const auto& [key, position] : allowed_clients) config.security.allowed_clients.push_back(key);
  for (const auto& [endpoint, key] : servers) config.security.servers.emplace(endpoint, key.value);
  Apply(peer_queue_bytes, config.peer_queue_bytes);
  Apply(heartbeat_ms, config.heartbeat_ms);
  Apply(peer_timeout_ms, config.peer_timeout_ms);
  if (config.peer_timeout_ms <= config.heartbeat_ms) {
    faults.Report(ConfigError("network.peer_timeout_ms is " + std::to_string(config.peer_timeout_ms) +
                                  ", not more than network.heartbeat_ms, which is " +
                                  std::to_string(config.heartbeat_ms) + ": every peer would be declared gone.",
                              peer_timeout_ms ? peer_timeout_ms->position : heartbeat_ms->position,
                              "Set the timeout to several heartbeats."));
  }
  if (discovery_local) {
    config.discovery.local = discovery_local->value.on;
    config.discovery.only = discovery_local->value.names;
  }
  if (discovery_lan) {
    config.discovery.lan = discovery_lan->value.on;
    config.discovery.lan_interfaces = discovery_lan->value.names;
  }
  Apply(domain, config.discovery.domain);
  Apply(shared_memory_limit_bytes, config.shared_memory.limit_bytes);
  Apply(shared_memory_wait, config.shared_memory.wait);
  Apply(shared_memory_spin_us, config.shared_memory.spin_us);
  Apply(simulated_time, config.simulated_time);
  Apply(control, config.control);
  config.closed_channels.assign(closed_channels.begin(), closed_channels.end());
  Apply(threads, config.threads);
  for (const auto& [name, node] : nodes) config.nodes[name] = {ValueOf(node.queue), ValueOf(node.executor)};
  for (const auto& [name, channel] : channels) {
    config.channels[name] = {ValueOf(channel.queue), ValueOf(channel.latched), ValueOf(channel.transports)};
  }
  return config;
}

Config Config::Load(std::span<const std::filesystem::path> files, std::span<const std::string> program_sections) {
  ConfigDraft draft;
  for (const std::filesystem::path& file : files) ReadFile(yaml::Document::Load(file), program_sections, draft);
  return draft.Finish();
}

Config Config::From(const yaml::Document& document, std::span<const std::string> program_sections) {
  ConfigDraft draft;
  ReadFile(document, program_sections, draft);
  return draft.Finish();
}

CheckedConfig CheckConfig(const yaml::Document& document, const ConfigCheckOptions& options) {
  CheckedConfig checked;
  ConfigDraft draft;
  draft.faults = yaml::Faults(checked.faults);
  draft.read_key_files = options.read_key_files;
  draft.faults.Attempt([&] { ReadFile(document, options.program_sections, draft); });
  checked.config = draft.Finish();
  return checked;
}

CheckedConfig CheckConfig(std::span<const std::filesystem::path> files, const ConfigCheckOptions& options) {
  CheckedConfig checked;
  ConfigDraft draft;
  draft.faults = yaml::Faults(checked.faults);
  draft.read_key_files = options.read_key_files;
  for (const std::filesystem::path& file : files) {
    draft.faults.Attempt([&] { ReadFile(yaml::Document::Load(file), options.program_sections, draft); });
  }
  checked.config = draft.Finish();
  return checked;
}

Config Config::Load(const std::filesystem::path& file) { return Load(std::span(&file, 1)); }

Config Config::Load(std::initializer_list<std::filesystem::path> files) {
  return Load(std::span(files.begin(), files.size()));
}

Config Config::OfEnvironment() {
  const char* const yaml = std::getenv("HGROS_CONFIG");
  return yaml == nullptr || *yaml == '\0' ? Config() : Parse(yaml, "HGROS_CONFIG");
}

Config Config::Parse(std::string_view yaml, std::string_view name) {
  return From(yaml::Document::Parse(yaml, std::string(name)));
}

}  // namespace hgros
