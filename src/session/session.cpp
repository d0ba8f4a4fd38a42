#include "hgros/session/session.hpp"

#include <utility>

#include "hgros/clock/time.hpp"
#include "session/session_core.hpp"

namespace hgros {

Session::Session() : Session(Config{}) {}
Session::Session(Config config, SessionOptions options)
    : core_(std::make_unique<Core>(std::move(config), std::move(options))) {}
Session::~Session() {
  if (core_->in_forked_child()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

bool Session::WaitForSubscribers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout) const {
  return core_->WaitForSubscribers(channel, count, timeout);
}
bool Session::WaitForPublishers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout) const {
  return core_->WaitForPublishers(channel, count, timeout);
}

std::shared_ptr<const MessageSchema> Session::AwaitSchema(std::string_view channel, std::chrono::nanoseconds timeout) {
  return core_->AwaitSchema(channel, timeout);
}

void Session::SetClosed(std::string_view channel, bool closed) { core_->graph().SetClosed(channel, closed); }
void Session::AllowPublishing(std::string_view channel, bool allowed) { core_->AllowPublishing(channel, allowed); }
void Session::AllowSubscribing(std::string_view channel, bool allowed) { core_->AllowSubscribing(channel, allowed); }
void Session::AddPublisherEndpoint(const EndpointConfig& endpoint) { core_->AddPublisherEndpoint(endpoint); }
void Session::AddSubscriberEndpoint(const EndpointConfig& endpoint) { core_->AddSubscriberEndpoint(endpoint); }
void Session::RemoveSubscriberEndpoint(std::string_view endpoint) { core_->RemoveSubscriberEndpoint(endpoint); }
std::vector<std::string> Session::PublisherEndpoints() const { return core_->PublisherEndpoints(); }

std::vector<PeerInfo> Session::Peers() const { return core_->Peers(); }
std::vector<KnownChannel> Session::Channels() const { return core_->Channels(); }
SessionSnapshot Session::Snapshot() const { return core_->Snapshot(); }
bool Session::WaitIdle(std::chrono::nanoseconds timeout) const { return core_->graph().WaitIdle(DeadlineIn(timeout)); }

NodeTimer Session::CreateTimer(std::string_view name, Duration period, TimerCallback callback,
                               NodeTimerOptions options) {
  return core_->timers().Create(name, period, std::move(callback), std::move(options));
}
const std::shared_ptr<Clock>& Session::clock() const noexcept { return core_->clock(); }

std::optional<ClockOffset> Session::OffsetTo(SessionId peer) const { return core_->OffsetTo(peer); }

SessionId Session::id() const noexcept { return core_->id(); }
const std::string& Session::name() const noexcept { return core_->name(); }
Log& Session::log() const noexcept { return core_->log(); }
Config Session::config() const { return core_->config(); }

Channel& Session::Open(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  return core_->Open(channel, type, where);
}
Channel& Session::OpenAny(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  return core_->OpenAny(channel, type, where);
}
std::shared_ptr<Channel> Session::Share(Channel& channel) const { return core_->graph().Share(channel); }
Block Session::LoanBlock(std::string_view channel, std::size_t size_bytes) {
  return core_->LoanBlock(channel, size_bytes);
}

Service Session::ServeAny(std::string_view name, const CallTypes& types, AnyHandler handler, Invoke invoke,
                          NodeOptions options, const CallSite& where) {
  return Service(core_->services().Serve(
      {std::string(name), &types.request, &types.reply, &types.body, invoke, std::move(handler)}, std::move(options),
      where));
}
std::shared_ptr<PendingCall> Session::CallAny(std::string_view name, const CallTypes& types, AnyMessage request,
                                              std::chrono::nanoseconds timeout,
                                              std::function<void(const CallEnd& end)> callback) {
  return core_->services().Call(name, {types.request, types.reply, types.body, std::move(request), timeout},
                                std::move(callback));
}

void Session::Latch(Channel& channel, std::size_t count) { core_->Latch(channel, count); }
Subscription Session::SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                   NodeOptions options) {
  return core_->SubscribeAny(channel, type, invoke, std::move(callback), std::move(options));
}
Subscription Session::SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                     NodeOptions options) {
  return core_->SubscribeGraph(channel, type, invoke, std::move(callback), std::move(options));
}

}  // namespace hgros
