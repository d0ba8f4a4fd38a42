// How a session reaches others: its carriers, its endpoints and their white lists.
#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "session/session_core.hpp"

namespace hgros {
namespace {

ChannelList ListOf(const EndpointConfig& endpoint) {
  if (endpoint.all_channels) return std::nullopt;
  return endpoint.channels;
}

// The list with or without the channel; a list of all stays one, since what it leaves out cannot be written down.
void Allow(EndpointConfig& endpoint, std::string_view channel, bool allowed) {
  auto& list = endpoint.channels;
  const auto place = std::lower_bound(list.begin(), list.end(), channel);
  const bool there = place != list.end() && *place == channel;
  if (allowed && !there) list.emplace(place, channel);
  if (!allowed && there) list.erase(place);
}

void RequireList(const EndpointConfig& endpoint, std::string_view channel) {
  if (!endpoint.all_channels) return;
  throw Error("The endpoint " + endpoint.endpoint + " lets every channel pass, so \"" + std::string(channel) +
                  "\" cannot be taken from its list.",
              {}, "Give the endpoint a list of channels in its configuration.");
}

}  // namespace

Carriers& Session::Core::Reach() {
  RequireOpen();
  if (carriers_) return *carriers_;
  if (!errands_) errands_.emplace();
  carriers_ = std::make_unique<Carriers>(OptionsForCarriers(), *this, *log_);
  for (auto& [name, outlet] : outlets_) outlet->Join(*carriers_);
  for (const auto& outlet : service_outlets_) outlet->Join(*carriers_);
  snapshots_.emplace(publisher_, log_, host_clocks_, SnapshotPublisher::Means{[this] { return Snapshot(); }, Later()});
  snapshots_->outlet()->Join(*carriers_);
  for (auto& [name, inflow] : inflows_) {
    if (inflow.wanted.empty() || inflow.joined || inflow.busy) continue;
    inflow.inlet->Join(*carriers_, Combine(inflow.wanted));
    inflow.joined = true;
  }
  return *carriers_;
}

std::function<void(std::chrono::nanoseconds, std::function<void()>)> Session::Core::Later() {
  return [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
    errands_->PostIn(delay, std::move(errand));
  };
}

CarrierOptions Session::Core::OptionsForCarriers() {
  CarrierOptions options;
  ZmqOptions& zmq = options.zmq;
  zmq.session = id_;
  zmq.process = name_;
  for (const EndpointConfig& endpoint : config_.publishers) {
    zmq.publish.push_back({endpoint.endpoint, ListOf(endpoint)});
  }
  for (const EndpointConfig& endpoint : config_.subscribers) {
    const auto key = config_.security.servers.find(endpoint.endpoint);
    zmq.subscribe.push_back(
        {endpoint.endpoint, ListOf(endpoint), key == config_.security.servers.end() ? std::string() : key->second});
  }
  zmq.heartbeat = std::chrono::milliseconds(config_.heartbeat_ms);
  zmq.peer_timeout = std::chrono::milliseconds(config_.peer_timeout_ms);
  zmq.peer_queue_bytes = config_.peer_queue_bytes;
  zmq.plain_queue_bytes = config_.peer_queue_bytes;
  zmq.linger = std::chrono::milliseconds(kLingerMs);
  zmq.wall = [clocks = host_clocks_] { return clocks->Now(); };
  if (config_.security.enabled()) {
    zmq.security =
        ZmqSecurity{{config_.security.public_key, config_.security.secret_key}, config_.security.allowed_clients};
  }
  for (const auto& [channel, entry] : config_.channels) {
    if (entry.carriers && !entry.carriers->all()) options.rules.emplace(channel, *entry.carriers);
  }
  if (domain_ && config_.discovery.local) {
    ShmOptions& shm = options.shm.emplace();
    shm.session = id_;
    shm.process = name_;
    shm.wait = config_.shared_memory.wait;
    shm.spin = std::chrono::microseconds(config_.shared_memory.spin_us);
    shm.limit_bytes = config_.shared_memory.limit_bytes;
    shm.heartbeat = zmq.heartbeat;
    shm.peer_timeout = zmq.peer_timeout;
    shm.peer_queue_bytes = zmq.peer_queue_bytes;
    options.registry.emplace().domain = *domain_;
    options.only = config_.discovery.only;
  }
  if (domain_ && config_.discovery.lan) {
    BeaconOptions& beacon = options.beacon.emplace();
    beacon.domain = *domain_;
    beacon.interfaces = config_.discovery.lan_interfaces;
  }
  options.on_announcements = [this] { services_->OnAnnouncements(); };
  options.later = Later();
  return options;
}

// A slip of the pen in a white list is otherwise nothing but silence. A sentence, or nothing if the channel may pass.
std::string Session::Core::Confined(std::string_view channel, const std::vector<EndpointConfig>& endpoints,
                                    Way way) const {
  std::vector<std::string> listed;
  for (const EndpointConfig& endpoint : endpoints) {
    if (endpoint.all_channels || std::binary_search(endpoint.channels.begin(), endpoint.channels.end(), channel)) {
      return {};
    }
    listed.insert(listed.end(), endpoint.channels.begin(), endpoint.channels.end());
  }
  if (endpoints.empty()) return {};
  const std::string nearest = NearestName(channel, listed);
  const std::string place = domain_ && config_.discovery.local ? "host" : "process";
  return "Channel \"" + std::string(channel) +
         (way == Way::kOut ? "\" is published, but does not leave this " + place + ": no publisher"
                           : "\" is subscribed to, but nothing enters this " + place + ": no subscriber") +
         " endpoint has it in its list of channels." +
         (nearest.empty() ? std::string() : " Did you mean \"" + nearest + "\"?");
}

// Part of a publish, so it must not wait; false if it could not look.
bool Session::Core::SayIfItCannotLeave(const std::string& channel) {
  std::string confined;
  {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return false;
    confined = Confined(channel, config_.publishers, Way::kOut);
  }
  if (!confined.empty()) log_->Write(LogLevel::kInfo, confined);
  return true;
}

void Session::Core::AllowPublishing(std::string_view channel, bool allowed) {
  RequireChannelName(channel);
  const std::scoped_lock lock(mutex_);
  for (EndpointConfig& endpoint : config_.publishers) {
    if (endpoint.all_channels && allowed) continue;
    RequireList(endpoint, channel);
    Allow(endpoint, channel, allowed);
    Reach().Zmq().SetPublishChannels(endpoint.endpoint, ListOf(endpoint));
  }
}

void Session::Core::AllowSubscribing(std::string_view channel, bool allowed) {
  RequireChannelName(channel);
  const std::scoped_lock lock(mutex_);
  for (EndpointConfig& endpoint : config_.subscribers) {
    if (endpoint.all_channels && allowed) continue;
    RequireList(endpoint, channel);
    Allow(endpoint, channel, allowed);
    Reach().Zmq().SetSubscribeChannels(endpoint.endpoint, ListOf(endpoint));
  }
}

void Session::Core::AddPublisherEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  Reach().AddPublishEndpoint({endpoint.endpoint, ListOf(endpoint)});
  config_.publishers.push_back(endpoint);
}

void Session::Core::AddSubscriberEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  const auto key = config_.security.servers.find(endpoint.endpoint);
  Reach().AddSubscribeEndpoint(
      {endpoint.endpoint, ListOf(endpoint), key == config_.security.servers.end() ? std::string() : key->second});
  config_.subscribers.push_back(endpoint);
}

void Session::Core::RemoveSubscriberEndpoint(std::string_view endpoint) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(config_.subscribers, [&](const EndpointConfig& one) { return one.endpoint == endpoint; });
  if (!carriers_ || !carriers_->RemoveSubscribeEndpoint(std::string(endpoint))) {
    throw Error("There is no subscriber endpoint " + std::string(endpoint) + ".");
  }
}

std::vector<std::string> Session::Core::PublisherEndpoints() const {
  const std::scoped_lock lock(mutex_);
  const ZmqTransport* const zmq = carriers_ ? carriers_->zmq() : nullptr;
  return zmq != nullptr ? zmq->BoundEndpoints() : std::vector<std::string>();
}

}  // namespace hgros
