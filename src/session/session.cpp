#include "hgros/session/session.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "hgros/base/session_name.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/config/endpoint_check.hpp"
#include "hgros/session/session_parts.hpp"
#include "session/session_core.hpp"

namespace hgros {

Session::Session() : Session(Config::OfEnvironment()) {}
Session::Session(Config config, SessionOptions options)
    : Session(std::make_unique<SessionCore>(std::move(config), std::move(options))) {}
Session::Session(std::unique_ptr<SessionCore> core)
    : SessionPublishing(*core),
      SessionSubscribing(*core),
      SessionServices(*core),
      SessionNetwork(*core),
      core_(std::move(core)) {}
Session::~Session() {
  if (!core_->MayBeDestroyed()) LeaveToParent(std::shared_ptr<const SessionCore>(std::move(core_)));
}

SessionSnapshot Session::Snapshot() const { return core_->Snapshot(); }
bool Session::WaitIdle(std::chrono::nanoseconds timeout) const { return core_->graph().WaitIdle(DeadlineIn(timeout)); }
bool SessionParts::SettleInput(std::string_view channel, std::chrono::nanoseconds timeout) const {
  const SessionCore& core = *session_.core_;
  return core.WaitUntil(timeout, [&] { return core.inbound_->IsSettled(channel); });
}
bool SessionParts::IsPublished(std::string_view channel) const {
  return session_.core_->outbound_.Find(channel) != nullptr;
}
std::vector<SessionParts::LatchedMessage> SessionParts::LatchedOn(std::string_view channel) const {
  std::vector<LatchedMessage> latched;
  if (const auto outlet = session_.core_->outbound_.Find(channel)) {
    for (OutboundMessage& one : outlet->Latched({})) latched.push_back({std::move(one.data), one.head.publish_time_ns});
  }
  return latched;
}
void SessionParts::KeepLatched(std::string_view channel, std::span<const LatchedMessage> messages, SessionId from) {
  const auto outlet = session_.core_->outbound_.Find(channel);
  if (!outlet) return;
  const TypeInfo& type = outlet->type();
  const bool raw = IsRunTimeType(type);
  std::vector<AnyMessage> kept;
  for (const LatchedMessage& one : messages) {
    AnyMessage message =
        raw ? std::make_shared<const RawMessage>(RawMessage{type.run_time->schema, one.data}) : type.decode(one.data);
    if (message == nullptr) continue;  // Another type than in the other place.
    if (outlet->KeepLatched(message, one.data, one.publish_time_ns)) kept.push_back(std::move(message));
  }
  session_.core_->graph().ReplaceLatched(channel, std::move(kept), raw ? AnyType() : type, from);
}
void SessionParts::ForgetLatched(std::string_view channel) {
  if (const auto outlet = session_.core_->outbound_.Find(channel)) outlet->ForgetLatched();
  DataGraph& graph = session_.core_->graph();
  // Nodes that come later beside others get it until the next message: to these, the other place does not send it.
  if (graph.NodeCount(channel) == 0) graph.ReplaceLatched(channel, {}, AnyType(), {});
}
void SessionParts::TakeServicesFrom(SessionId other) { session_.core_->services().TakeFrom(other); }
void SessionParts::EndWaits() noexcept {
  SessionCore& core = *session_.core_;
  core.services_->Refuse();
  core.ends_waits_ = true;
  core.changes_.Notify();
}
void SessionParts::LeaveInside() noexcept { (void)session_.core_->MayBeDestroyed("program"); }
Time Session::SettleTimers() { return core_->timers().Settle(); }
NodeTimer Session::CreateTimer(std::string_view name, Duration period, TimerCallback callback,
                               NodeTimerOptions options) {
  return core_->timers().Create(name, period, std::move(callback), std::move(options));
}
const std::shared_ptr<Clock>& Session::clock() const noexcept { return core_->clock(); }
SessionId Session::id() const noexcept { return core_->id(); }
const std::string& Session::name() const noexcept { return core_->name(); }
Log& Session::log() const noexcept { return core_->log(); }
Config Session::config() const { return core_->config(); }
std::shared_ptr<const void> Session::TryReserve(std::string_view name) { return core_->TryReserve(name); }

PublishStatus SessionPublishing::ToAnyRaw(std::string_view channel, const MessageSchema& schema, const Payload& data,
                                          const CallSite& where) {
  const TypeInfo& type = RunTimeType(schema);
  return PublishRaw(OpenAny(channel, type, where), type.run_time->schema, data, Reach::kAny);
}
RawPublisher SessionPublishing::AdvertiseRaw(std::string_view channel, const MessageSchema& schema,
                                             PublishOptions options, const CallSite& where) {
  const TypeInfo& type = RunTimeType(schema);
  Channel& opened = OpenAny(channel, type, where);
  Latch(opened, options.latched);
  return RawPublisher(Share(opened), type.run_time->schema, Reach::kAny);
}
bool SessionPublishing::WaitForSubscribers(std::string_view channel, std::size_t count,
                                           std::chrono::nanoseconds timeout) const {
  return publishing_core_.WaitForSubscribers(channel, count, timeout);
}
void SessionPublishing::SetClosed(std::string_view channel, bool closed) {
  publishing_core_.graph().SetClosed(channel, closed);
}
Channel& SessionPublishing::OpenInGraph(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  return publishing_core_.graph().Open(channel, type, where);
}
Channel& SessionPublishing::OpenAny(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  return publishing_core_.OpenAny(channel, type, where);
}
std::shared_ptr<Channel> SessionPublishing::Share(Channel& channel) const {
  return publishing_core_.graph().Share(channel);
}
Block SessionPublishing::LoanBlock(std::string_view channel, std::size_t size_bytes) {
  return publishing_core_.LoanBlock(channel, size_bytes);
}
void SessionPublishing::Latch(Channel& channel, std::size_t count) { publishing_core_.Latch(channel, count); }

std::shared_ptr<const MessageSchema> SessionSubscribing::AwaitSchema(std::string_view channel,
                                                                     std::chrono::nanoseconds timeout) {
  return subscribing_core_.AwaitSchema(channel, timeout);
}
bool SessionSubscribing::WaitForPublishers(std::string_view channel, std::size_t count,
                                           std::chrono::nanoseconds timeout) const {
  return subscribing_core_.WaitForPublishers(channel, count, timeout);
}
Channel& SessionSubscribing::OpenToSubscribe(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  RequireOtherThanRequests(channel, where);
  return subscribing_core_.graph().Open(channel, type, where);
}
Channel& SessionSubscribing::OpenToSubscribe(std::string_view channel, const MessageSchema& type,
                                             const CallSite& where) {
  return OpenToSubscribe(channel, RunTimeType(type), where);
}
Subscription SessionSubscribing::SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke,
                                              AnyCallback callback, NodeOptions options) {
  return subscribing_core_.SubscribeAny(channel, type, invoke, std::move(callback), std::move(options));
}
Subscription SessionSubscribing::SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke,
                                                AnyCallback callback, NodeOptions options) {
  return subscribing_core_.SubscribeGraph(channel, type, invoke, std::move(callback), std::move(options));
}

AnyHandler SessionParts::HandlerOf(RawHandler handler, const TypeInfo& reply) {
  return [handler = std::move(handler), schema = reply.run_time->schema](const AnyMessage& message) -> AnyMessage {
    const Payload data = handler(*static_cast<const RawMessage*>(message.get()));
    return std::make_shared<const RawMessage>(RawMessage{schema, OwnedPayload(data)});
  };
}
Service SessionServices::ServeRaw(std::string_view name, const MessageSchema& request, const MessageSchema& reply,
                                  RawHandler handler, Invoke invoke, NodeOptions options, const CallSite& where) {
  const TypeInfo& reply_body = RunTimeType(reply);
  return ServeAny(name, {RunTimeCallType(request), RunTimeCallType(reply), RunTimeType(request), reply_body},
                  SessionParts::HandlerOf(std::move(handler), reply_body), invoke, std::move(options), where);
}
CallFuture<RawMessage> SessionServices::CallRaw(std::string_view name, const MessageSchema& request_schema,
                                                const Payload& request, const MessageSchema& reply,
                                                std::chrono::nanoseconds timeout) {
  return CallFuture<RawMessage>(CallBytes(name, request_schema, request, reply, timeout, {}, Executor::Tbb()));
}
std::shared_ptr<PendingCall> SessionServices::CallBytes(std::string_view name, const MessageSchema& request_schema,
                                                        const Payload& request, const MessageSchema& reply,
                                                        std::chrono::nanoseconds timeout, AnyAnswer callback,
                                                        const Executor& executor) {
  if (executor.kind() == Executor::Kind::kDedicated) throw Error("A callback of a call has no thread of its own.");
  const TypeInfo& body = RunTimeType(request_schema);
  const bool any = reply.type_name.empty();
  auto message = std::make_shared<const RawMessage>(RawMessage{body.run_time->schema, OwnedPayload(request)});
  return CallAny(name,
                 {RunTimeCallType(request_schema), any ? AnyType() : RunTimeCallType(reply), body,
                  any ? AnyType() : RunTimeType(reply)},
                 std::move(message), timeout, std::move(callback), executor.kind() == Executor::Kind::kInline);
}
Service SessionServices::ServeAny(std::string_view name, const CallTypes& types, AnyHandler handler, Invoke invoke,
                                  NodeOptions options, const CallSite& where) {
  Service service(services_core_.services().Serve({std::string(name), &types.request, &types.reply, &types.request_body,
                                                   &types.reply_body, invoke, std::move(handler)},
                                                  std::move(options), where));
  services_core_.changes_.Notify();
  return service;
}
std::shared_ptr<PendingCall> SessionServices::CallAny(std::string_view name, const CallTypes& types, AnyMessage request,
                                                      std::chrono::nanoseconds timeout, AnyAnswer callback,
                                                      bool answers_inline) {
  return services_core_.services().Call(
      name, {types.request, types.reply, types.request_body, std::move(request), timeout, answers_inline},
      std::move(callback));
}

bool SessionServices::WaitForService(std::string_view name, std::chrono::nanoseconds timeout) const {
  RequireServiceName(name);
  const std::string requests = RequestChannel(name);
  const auto is_other = [own = services_core_.id()](const ChannelUser& one) { return one.session != own; };
  return services_core_.WaitUntil(timeout, [&] {
    if (services_core_.services().HostOf(name)) return true;
    const std::vector<KnownChannel> channels = services_core_.Channels();
    const auto found = std::ranges::find(channels, requests, &KnownChannel::name);
    return found != channels.end() && std::ranges::any_of(found->subscribers, is_other);
  });
}

void SessionNetwork::AllowPublishing(std::string_view channel, bool allowed) {
  network_core_.Allow(Way::kOut, channel, allowed);
}
void SessionNetwork::AllowSubscribing(std::string_view channel, bool allowed) {
  network_core_.Allow(Way::kIn, channel, allowed);
}
void SessionNetwork::AddPublisherEndpoint(const EndpointConfig& endpoint) {
  RequireEndpoint(endpoint.endpoint, EndpointSide::kPublisher);
  network_core_.AddPublisherEndpoint(endpoint);
}
void SessionNetwork::AddSubscriberEndpoint(const EndpointConfig& endpoint) {
  RequireEndpoint(endpoint.endpoint, EndpointSide::kSubscriber);
  network_core_.AddSubscriberEndpoint(endpoint);
}
void SessionNetwork::RemoveSubscriberEndpoint(std::string_view endpoint) {
  network_core_.RemoveSubscriberEndpoint(endpoint);
}
std::vector<std::string> SessionNetwork::PublisherEndpoints() const { return network_core_.PublisherEndpoints(); }
std::optional<ClockOffset> SessionNetwork::OffsetTo(SessionId peer) const { return network_core_.OffsetTo(peer); }
bool SessionNetwork::ReceiveHere(const std::function<bool()>& done, std::chrono::steady_clock::time_point until) {
  NetworkBridge* const bridge = network_core_.bridge();
  receiving_.store(bridge);
  return bridge != nullptr && bridge->ReceiveHere({.done = done, .until = until});
}
void SessionNetwork::WakeReceiver() const noexcept {
  if (NetworkBridge* const bridge = receiving_.load()) bridge->WakeReceiver();
}
std::vector<PeerInfo> SessionNetwork::Peers() const { return network_core_.Peers(); }
std::string SessionNetwork::NameOf(SessionId session) const {
  if (session == network_core_.id()) return SessionName(network_core_.name(), getpid());
  const std::vector<PeerInfo> peers = Peers();
  const auto peer = std::ranges::find(peers, session, &PeerInfo::id);
  return peer == peers.end() ? session.ToString() : peer->name();
}
std::vector<KnownChannel> SessionNetwork::Channels() const { return network_core_.Channels(); }

}  // namespace hgros
