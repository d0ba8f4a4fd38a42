// The part of SessionCore that reaches other sessions: transports, endpoints and their lists of channels.
#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "session/bridge_options.hpp"
#include "session/session_core.hpp"

namespace hgros {
NetworkBridge& SessionCore::EnsureTransports() {
  if (bridge_) return *bridge_;
  if (!errands_) errands_.emplace(log_);
  BridgeOptions options = BridgeOptionsOf(config_, {id_, name_, domain_, kLinger}, host_clocks_);
  options.on_announcements = [this] { services_->OnAnnouncements(); };
  options.later = Later();
  bridge_ = std::make_unique<NetworkBridge>(std::move(options), *this, *log_);
  outbound_.Join(*bridge_);
  reports_.emplace(OwnReports::Self{name_, publisher_, TraceRecorder::Of(*graph_), log_, host_clocks_},
                   SnapshotPublisher::Means{[this] { return Snapshot(); }, Later()});
  reports_->Join(*bridge_);
  inbound_->Join(*bridge_);
  if (!config_.control) return *bridge_;
  const auto list = [this](Way way, const std::string& channel) { Allow(way, channel, true); };
  steering_.emplace(
      *bridge_, Steering::Means{id_, log_, *graph_, outbound_, *inbound_, [this] { return Peers(); }, list, Later()});
  return *bridge_;
}

std::function<void(std::chrono::nanoseconds, std::function<void()>)> SessionCore::Later() {
  return [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
    errands_->PostIn(delay, std::move(errand));
  };
}

// Runs inside a publish, so it must not wait. False if the lock was not free.
bool SessionCore::SayIfItCannotLeave(const std::string& channel) {
  std::string confined;
  {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return false;
    confined = DescribeConfined(channel, config_.publishers, Way::kOut, OutermostPlace(config_, domain_.has_value()));
  }
  if (!confined.empty()) log_->Write(LogLevel::kDebug, confined);
  return true;
}

void SessionCore::Allow(Way way, std::string_view channel, bool allowed) {
  RequireChannelName(channel);
  const std::scoped_lock lock(mutex_);
  for (EndpointConfig& endpoint : way == Way::kOut ? config_.publishers : config_.subscribers) {
    if (!SetAllowed(endpoint, channel, allowed) || !TakesWiring()) continue;
    const auto set = way == Way::kOut ? &NetworkBridge::SetPublishChannels : &NetworkBridge::SetSubscribeChannels;
    (EnsureTransports().*set)(endpoint.endpoint, ListOf(endpoint));
  }
}

void SessionCore::AddPublisherEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  if (!TakesWiring()) return;
  EnsureTransports().AddPublishEndpoint({endpoint.endpoint, ListOf(endpoint)});
  config_.publishers.push_back(endpoint);
}

void SessionCore::AddSubscriberEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  if (!TakesWiring()) return;
  const auto key = config_.security.servers.find(endpoint.endpoint);
  EnsureTransports().AddSubscribeEndpoint(
      {endpoint.endpoint, ListOf(endpoint), key == config_.security.servers.end() ? std::string() : key->second});
  config_.subscribers.push_back(endpoint);
}

void SessionCore::RemoveSubscriberEndpoint(std::string_view endpoint) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(config_.subscribers, [&](const EndpointConfig& one) { return one.endpoint == endpoint; });
  if (!bridge_ || !bridge_->RemoveSubscribeEndpoint(std::string(endpoint))) {
    throw Error("There is no subscriber endpoint " + std::string(endpoint) + ".");
  }
}

std::vector<std::string> SessionCore::PublisherEndpoints() const {
  const std::scoped_lock lock(mutex_);
  return bridge_ ? bridge_->BoundEndpoints() : std::vector<std::string>();
}

}  // namespace hgros
