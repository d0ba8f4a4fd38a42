#include "session/bridge_options.hpp"

#include "session/endpoint_lists.hpp"

namespace hgros {

BridgeOptions BridgeOptionsOf(const Config& config, const BridgeIdentity& self,
                              const std::shared_ptr<HostClocks>& clocks) {
  BridgeOptions options;
  ZmqOptions& zmq = options.zmq;
  zmq.session = self.id;
  zmq.process = self.name;
  for (const EndpointConfig& endpoint : config.publishers) {
    zmq.publish.push_back({endpoint.endpoint, ListOf(endpoint)});
  }
  for (const EndpointConfig& endpoint : config.subscribers) {
    const auto key = config.security.servers.find(endpoint.endpoint);
    zmq.subscribe.push_back(
        {endpoint.endpoint, ListOf(endpoint), key == config.security.servers.end() ? std::string() : key->second});
  }
  zmq.heartbeat = std::chrono::milliseconds(config.heartbeat_ms);
  zmq.peer_timeout = std::chrono::milliseconds(config.peer_timeout_ms);
  zmq.peer_queue_bytes = config.peer_queue_bytes;
  zmq.plain_queue_bytes = config.peer_queue_bytes;
  zmq.linger = self.linger;
  zmq.wall = [clocks] { return clocks->Now(); };
  if (config.security.enabled()) {
    zmq.security =
        ZmqSecurity{{config.security.public_key, config.security.secret_key}, config.security.allowed_clients};
  }
  for (const auto& [channel, entry] : config.channels) {
    if (entry.transports) options.rules.emplace(channel, entry.transports);
  }
  if (self.domain && config.discovery.local) {
    ShmOptions& shm = options.shm.emplace();
    shm.session = self.id;
    shm.process = self.name;
    shm.wait = config.shared_memory.wait;
    shm.spin = std::chrono::microseconds(config.shared_memory.spin_us);
    shm.limit_bytes = config.shared_memory.limit_bytes;
    shm.heartbeat = zmq.heartbeat;
    shm.peer_timeout = zmq.peer_timeout;
    shm.peer_queue_bytes = zmq.peer_queue_bytes;
    options.registry.emplace().domain = *self.domain;
    options.only = config.discovery.only;
  }
  if (self.domain && config.discovery.lan) {
    BeaconOptions& beacon = options.beacon.emplace();
    beacon.domain = *self.domain;
    beacon.interfaces = config.discovery.lan_interfaces;
  }
  return options;
}

}  // namespace hgros
