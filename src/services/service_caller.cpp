#include "services/service_caller.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "hgros/codec/run_time_type.hpp"
#include "hgros/graph/ready_node_slot.hpp"
#include "hgros/services/services.hpp"
#include "services/call_table.hpp"
#include "services/service_host.hpp"

namespace hgros {
namespace {

using Kind = CallFailure::Kind;

constexpr std::size_t kRepliesInFlight = 1024;
// If replies usually take longer than this, the caller sleeps while it waits.
constexpr std::int64_t kSoonNs = 150'000;
constexpr std::int64_t kMostCountedNs = 3 * kSoonNs;  // Limits the effect of one slow reply on the average.
constexpr std::size_t kSmallBytes = 64 * 1024;
constexpr auto kTimeForTheReason = std::chrono::milliseconds(50);
// A service that moves to another session is served by two for a moment.
constexpr auto kTimeToMove = std::chrono::seconds(1);

}  // namespace

ServiceCaller::ServiceCaller(std::string name, const TypeInfo& request, const TypeInfo& reply,
                             const std::shared_ptr<Services>& services)
    : name_(std::move(name)), request_(request), reply_(reply), services_(services) {}

void ServiceCaller::Start() {
  const auto services = services_.lock();
  const auto update = [weak = weak_from_this(), desk = services_] {
    if (const auto alive = desk.lock()) {
      alive->Post([weak, desk] {
        if (const auto wired = desk.lock()) wired->AwaitWiring();  // The update may come while Start still runs.
        if (const auto client = weak.lock()) client->Update();
      });
    }
  };
  services->With([&](ServicePlace& place) {
    replies_ = place.Listen(
        ReplyChannel(name_, services->id()), reply_,
        [weak = weak_from_this()](const AnyMessage& message, const MessageInfo& info) {
          const auto client = weak.lock();
          if (!client) return;
          const AnyMessage read = client->AsCall(message);
          if (read) client->OnReply(*static_cast<const CallMessage*>(read.get()), info);
        },
        kRepliesInFlight);
    OutletEvents events{update, update, [] { return true; }};
    events.on_unsubscribed = [weak = weak_from_this()](SessionId server) {
      if (const auto client = weak.lock()) client->OnEnded(server);
    };
    outlet_ = place.OpenOutlet(RequestChannel(name_), request_, std::move(events));
  });
}

// A reply whose type is known only at run time arrives without its schema, which is added here.
AnyMessage ServiceCaller::AsCall(const AnyMessage& message) const {
  if (!IsAnyType(reply_) && reply_.run_time == nullptr) return message;
  AnyMessage read = message;
  std::shared_ptr<const MessageSchema> schema;
  if (IsAnyType(reply_)) {
    const auto& raw = *static_cast<const RawMessage*>(message.get());
    read = codec::DecodeCall(raw.data, AnyType());
    schema = raw.schema;
  } else {
    schema = reply_.run_time->schema;
  }
  if (!read) return nullptr;
  auto call = std::make_shared<CallMessage>(*static_cast<const CallMessage*>(read.get()));
  if (call->body) {
    const auto& body = *static_cast<const RawMessage*>(call->body.get());
    call->body = std::make_shared<const RawMessage>(RawMessage{std::move(schema), body.data});
  }
  return call;
}

void ServiceCaller::OnReply(const CallMessage& reply, const MessageInfo& info) {
  const auto services = services_.lock();
  if (!services || !info.remote || reply.caller != services->id().value) return;
  // The body has this client's type, so the call must belong to this client. Only the call's server may reply.
  const auto call = services->calls()->Find(reply.call);
  if (!call || !call->IsOf(*this) || call->server().value != info.id.publisher) return;
  const std::int64_t took = std::min<std::int64_t>(call->Age().count(), kMostCountedNs);
  usual_ns_.store((3 * usual_ns_.load(std::memory_order_relaxed) + took) / 4, std::memory_order_relaxed);
  const ReadyNodeSlot::Opened opened;
  services->EndCall(reply, name_);
}

PublishStatus ServiceCaller::PostAndLook(const CallState& call, Services& services) {
  std::optional<PublishStatus> sent;
  const auto post = [&] { sent = Post(call.message); };
  // No other thread receives meanwhile, so a message that takes long to write is excluded.
  const auto is_small = [&] {
    const TypeInfo& body = *call.message->type;
    return !body.users_codec && body.encoded_bytes != nullptr && request_.encoded_bytes != nullptr &&
           request_.encoded_bytes(call.message.get()) <= kSmallBytes;
  };
  if (call.may_be_waited_for() && usual_ns_.load(std::memory_order_relaxed) <= kSoonNs && is_small()) {
    services.With([&](ServicePlace& place) {
      place.Receive(
          {.done = [&call] { return call.done(); }, .until = std::chrono::steady_clock::now(), .first = post});
    });
  }
  if (!sent) post();
  return *sent;
}

PublishStatus ServiceCaller::Post(const std::shared_ptr<const CallMessage>& message) {
  if (outlet_->subscriber_count() == 0) return PublishStatus::kFull;
  return SendCall(*outlet_, message, request_);
}

void ServiceCaller::Send(const std::shared_ptr<CallState>& call) {
  const auto services = services_.lock();
  if (!services || !outlet_) return;
  std::vector<std::shared_ptr<CallState>> ended;  // Released after the lock.
  bool now = false;
  {
    const std::scoped_lock lock(mutex_);
    now = waiting_.empty() && !servers_.empty();
    if (now) {
      if (!call->GoesTo(shared_from_this(), servers_.front().id, ends_)) return;
      call->message->server = servers_.front().id.value;
    } else {
      while (!waiting_.empty() && waiting_.front()->done()) {
        ended.push_back(std::move(waiting_.front()));
        waiting_.pop_front();
      }
      call->AwaitsServerOf(shared_from_this());
      waiting_.push_back(call);
    }
  }
  if (now) {
    const PublishStatus status = PostAndLook(*call, *services);
    if (status == PublishStatus::kOk) return;
    if (status != PublishStatus::kFull) {
      services->calls()->End(call->number, NotWritten(name_, status));
      return;
    }
    const std::scoped_lock lock(mutex_);  // The server has no room at the moment.
    call->AwaitsServerOf(shared_from_this());
    waiting_.push_back(call);
  } else if (const auto host = services->HostOf(name_)) {  // It was registered after Dispatch() looked for it.
    return HandOver(*host);
  }
  services->Post([weak = weak_from_this()] {
    if (const auto client = weak.lock()) client->Update();
  });
}

void ServiceCaller::HandOver(ServiceHost& host) {
  std::deque<std::shared_ptr<CallState>> waiting;
  {
    const std::scoped_lock lock(mutex_);
    waiting.swap(waiting_);
    if (!host.Fits(request_, reply_)) waiting.swap(waiting_);
  }
  for (const auto& call : waiting) {
    if (call->GoesTo(host.shared_from_this())) host.Arrive(call->message);
  }
}

void ServiceCaller::AwaitQuickly(const CallState& call) {
  const std::int64_t usual = usual_ns_.load(std::memory_order_relaxed);
  const auto services = services_.lock();
  if (usual > kSoonNs || !services || !call.has_server()) return;
  const auto until = std::chrono::steady_clock::now() + std::chrono::nanoseconds(std::max(2 * usual, kSoonNs / 2));
  services->With(
      [&](ServicePlace& place) { place.Receive({.done = [&call] { return call.done(); }, .until = until}); });
}

void ServiceCaller::Withdraw(const CallState& call) {
  if (!call.has_server()) return;
  auto message = std::make_shared<CallMessage>();
  message->caller = call.message->caller;
  message->server = call.server().value;
  message->call = call.number;
  message->cancelled = true;
  (void)Post(message);  // If there is no room, the reply arrives and is ignored.
}

void ServiceCaller::Update() {
  const auto services = services_.lock();
  if (!services || !outlet_) return;
  UpdateServers(*services);
  SendWaiting(*services);
  EndWithoutServer(*services);
}

void ServiceCaller::UpdateServers(Services& services) {
  // subscriber_count() follows Subscribers() after a short delay, and the outlet sends nothing before. Update() is
  // called again then.
  const bool told = outlet_->subscriber_count() > 0;
  const std::vector<SessionId> there = told ? outlet_->Subscribers() : std::vector<SessionId>();
  std::vector<PeerInfo> peers;
  std::chrono::milliseconds silence{0};  // A killed server is still among the servers for this time.
  services.With([&](ServicePlace& place) {
    peers = place.Peers();
    silence = std::chrono::milliseconds(place.LongestSilenceMs());
  });
  std::vector<Server> gone;
  std::vector<std::pair<Server, std::uint64_t>> again;  // Have ended the service, and serve it again.
  std::chrono::steady_clock::time_point second;
  bool two = false;
  std::uint64_t end = 0;  // Of those that are gone. A call that goes to one that is back comes later.
  {
    const std::scoped_lock lock(mutex_);
    const auto serves = [&](SessionId id) {
      return std::ranges::find(there, id) != there.end() && !misfits_.contains(id.value);
    };
    for (const Server& server : servers_) {
      if (!serves(server.id)) gone.push_back(server);
    }
    std::erase_if(servers_, [&](const Server& server) { return !serves(server.id); });
    if (!gone.empty()) end = ++ends_;
    for (const Ended& ended : std::exchange(ended_, {})) {
      const auto server = std::ranges::find(servers_, ended.server, &Server::id);
      if (server != servers_.end()) again.emplace_back(*server, ended.end);
    }
    for (const SessionId id : there) {
      if (!serves(id) || std::ranges::find(servers_, id, &Server::id) != servers_.end()) continue;
      Server& server = servers_.emplace_back();
      server.id = server.info.id = id;
      if (const auto peer = std::ranges::find(peers, id, &PeerInfo::id); peer != peers.end()) server.info = *peer;
    }
    if (servers_.size() > 1) second = servers_[1].since;
    two = second != std::exchange(second_since_, second) && servers_.size() > 1;
  }
  for (const Server& server : gone) EndCallsSoon(services, server, end);
  for (const auto& [server, its_end] : again) EndCallsSoon(services, server, its_end);
  if (two)
    services.PostAt(second + silence + kTimeToMove, [weak = weak_from_this(), second] {
      if (const auto client = weak.lock()) client->SayIfTwoServe(second);
    });
}

void ServiceCaller::OnEnded(SessionId server) {
  const std::scoped_lock lock(mutex_);
  ended_.push_back({server, ++ends_});
}

void ServiceCaller::EndCallsSoon(Services& services, const Server& server, std::uint64_t end) {
  std::vector<std::uint64_t> lost;
  const auto has_lost = [server = server.id, end](const CallState& call) {
    return call.server() == server && call.ends_before() < end;
  };
  services.calls()->EndAll([&](const CallState& call) -> std::optional<CallEnd> {
    if (call.IsOf(*this) && has_lost(call)) lost.push_back(call.number);
    return std::nullopt;
  });
  if (lost.empty()) return;
  CallEnd failed = Failed(Kind::kServerGone, "Session " + server.info.name() + " ended service \"" + name_ +
                                                 "\", or can no longer be reached.");
  services.PostAt(std::chrono::steady_clock::now() + kTimeForTheReason,
                  [desk = services_, lost = std::move(lost), failed = std::move(failed), has_lost] {
                    const auto still = desk.lock();
                    for (const std::uint64_t number : lost) {
                      const auto call = still ? still->calls()->Find(number) : nullptr;
                      if (call && has_lost(*call))
                        still->calls()->End(number, failed);  // Another server may have it now.
                    }
                  });
}

void ServiceCaller::SendWaiting(Services& services) {
  for (;;) {
    std::shared_ptr<CallState> next;
    {
      const std::scoped_lock lock(mutex_);
      if (waiting_.empty() || servers_.empty()) return;
      next = waiting_.front();
      waiting_.pop_front();
      if (!next->GoesTo(shared_from_this(), servers_.front().id, ends_)) continue;
      next->message->server = servers_.front().id.value;
    }
    const PublishStatus status = Post(next->message);
    if (status == PublishStatus::kOk) continue;
    if (status != PublishStatus::kFull) {
      services.calls()->End(next->number, NotWritten(name_, status));
      continue;
    }
    const std::scoped_lock lock(mutex_);
    next->AwaitsServerOf(shared_from_this());
    waiting_.push_front(std::move(next));
    return;
  }
}

void ServiceCaller::EndWithoutServer(Services& services) {
  std::string misfit;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(waiting_, [](const auto& call) { return call->done(); });
    if (waiting_.empty() || !servers_.empty()) return;
    if (!misfits_.empty()) misfit = misfits_.begin()->second;
  }
  if (!misfit.empty()) return EndWaiting(Failed(Kind::kTypeMismatch, misfit));
  ChannelSearch search;
  services.With([&](ServicePlace& place) { search = place.Search(RequestChannel(name_)); });
  if (!search.announced.empty()) return;  // A server is announced and will be connected soon.
  if (search.complete) {
    return EndWaiting(Failed(Kind::kNoServer,
                             "Nobody serves \"" + name_ + "\": discovery knows no session that does." + Suggestion()));
  }
  if (search.complete_at == std::chrono::steady_clock::time_point::max()) {
    {
      const std::scoped_lock lock(mutex_);
      if (std::exchange(says_waiting_, true)) return;
    }
    return services.PostAt(std::chrono::steady_clock::now() + kTimeForServers, [weak = weak_from_this()] {
      if (const auto client = weak.lock()) client->SayIfCallsWait(false);
    });
  }
  services.PostAt(search.complete_at, [weak = weak_from_this()] {
    if (const auto client = weak.lock()) client->Update();
  });
}

void ServiceCaller::EndWaiting(const CallEnd& end) {
  std::deque<std::shared_ptr<CallState>> waiting;
  {
    const std::scoped_lock lock(mutex_);
    waiting.swap(waiting_);
  }
  const auto services = services_.lock();
  for (const auto& call : waiting) services->calls()->End(call->number, end);
}

void ServiceCaller::EndCallsTo(Services& services, SessionId server, const CallEnd& end) {
  services.calls()->EndAll([&](const CallState& call) {
    return call.IsOf(*this) && call.server() == server ? std::optional(end) : std::nullopt;
  });
}

void ServiceCaller::OnPeerGone(const PeerInfo& peer, const std::string& reason) {
  const auto services = services_.lock();
  if (!services) return;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(servers_, [&](const Server& server) { return server.id == peer.id; });
    misfits_.erase(peer.id.value);
  }
  EndCallsTo(*services, peer.id,
             Failed(Kind::kServerGone,
                    "Session " + peer.name() + ", which served \"" + name_ + "\", is gone: " + reason + "."));
  Update();
}

void ServiceCaller::OnMisfit(std::string_view channel, SessionId peer, const std::string& sentence) {
  const auto services = services_.lock();
  if (!services) return;
  if (channel != RequestChannel(name_) && channel != ReplyChannel(name_, services->id())) return;
  {
    const std::scoped_lock lock(mutex_);
    misfits_[peer.value] = sentence;
    std::erase_if(servers_, [&](const Server& server) { return server.id == peer; });
  }
  EndCallsTo(*services, peer, Failed(Kind::kTypeMismatch, sentence));
  Update();
}

}  // namespace hgros
