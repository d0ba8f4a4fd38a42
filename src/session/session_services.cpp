// The part of SessionCore that implements ServicePlace.
#include <utility>

#include "hgros/graph/trace_recorder.hpp"
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

// Lists name the requests' channel for both directions.
ReplyWays WaysIn(const Config& config, const InboundChannels& inbound, SessionId session, const std::string& service) {
  const std::string listed = RequestChannel(service);
  return {.leave = DescribeConfined(listed, config.publishers, Way::kOut, {}).empty(),
          .enter = DescribeConfined(listed, config.subscribers, Way::kIn, {}).empty(),
          .offered = inbound.PublisherCount(ReplyChannel(service, session))};
}

}  // namespace

Subscription SessionCore::Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                                 std::size_t queue_depth) {
  return SubscribeAny(graph_->Open(channel, type, CallSite::Current()), type, Invoke::kConcurrent, std::move(callback),
                      {.name = channel, .queue = Queue::KeepAll(queue_depth), .executor = Executor::Inline()});
}

std::shared_ptr<SessionOutlet> SessionCore::OpenOutlet(const std::string& channel, const TypeInfo& type,
                                                       OutletEvents events) {
  {
    const std::scoped_lock lock(mutex_);
    if (TakesWiring() && domain_) EnsureTransports();
  }
  events.on_numbered = TraceRecorder::OfOutlets(*graph_);
  return outbound_.OpenForService(channel, type, std::move(events));
}

void SessionCore::Receive(const Visit& visit) noexcept {
  NetworkBridge* const used = bridge();
  used != nullptr ? used->Receive(visit) : visit.first();
}

ChannelSearch SessionCore::Search(const std::string& channel) {
  const std::scoped_lock lock(mutex_);
  return bridge_ ? bridge_->Search(channel) : ChannelSearch{.announced = {}, .complete = true, .complete_at = {}};
}

OrderWay SessionCore::SendOrder(SessionId publisher, std::string_view request) {
  const std::scoped_lock lock(mutex_);
  return bridge_ ? bridge_->SendOrder(publisher, request) : OrderWay::kNone;
}

ReplyWays SessionCore::WaysOf(const std::string& service) const { return WaysIn(config(), *inbound_, id_, service); }

std::vector<std::string> SessionCore::KnownServices() { return ServicesAmong(Channels()); }

}  // namespace hgros
