// The part of SessionCore that implements ServicePlace.
#include <utility>

#include "session/session_core.hpp"

namespace hgros {
namespace {

std::vector<std::string> ServicesAmong(const std::vector<KnownChannel>& channels) {
  const std::string requests = RequestChannel("");
  std::vector<std::string> services;
  for (const KnownChannel& one : channels) {
    if (!one.subscribers.empty() && one.name.starts_with(requests))
      services.push_back(one.name.substr(requests.size()));
  }
  return services;
}

}  // namespace

Subscription SessionCore::Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                                 std::size_t queue_depth) {
  Channel& opened = graph_->Open(channel, type, CallSite::Current());
  NodeOptions options;
  options.name = channel;
  options.queue = Queue::KeepAll(queue_depth);
  options.executor = Executor::Inline();
  return SubscribeAny(opened, type, Invoke::kConcurrent, std::move(callback), std::move(options));
}

std::shared_ptr<SessionOutlet> SessionCore::OpenOutlet(const std::string& channel, const TypeInfo& type,
                                                       OutletEvents events) {
  {
    const std::scoped_lock lock(mutex_);
    if (TakesWiring() && domain_) EnsureTransports();
  }
  return outbound_.OpenForService(channel, type, std::move(events));
}

void SessionCore::CloseOutlet(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet) {
  outbound_.CloseForService(channel, outlet);
}

void SessionCore::Receive(const Visit& visit) noexcept {
  NetworkBridge* bridge = nullptr;  // It exists as long as services may call.
  {
    const std::scoped_lock lock(mutex_);
    bridge = bridge_.get();
  }
  bridge != nullptr ? bridge->Receive(visit) : visit.first();
}

ChannelSearch SessionCore::Search(const std::string& channel) {
  const std::scoped_lock lock(mutex_);
  if (bridge_) return bridge_->Search(channel);
  return {.announced = {}, .complete = true, .complete_at = {}};
}

std::vector<std::string> SessionCore::KnownServices() { return ServicesAmong(Channels()); }

}  // namespace hgros
