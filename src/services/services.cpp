#include "hgros/services/services.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "services/call_table.hpp"
#include "services/service_caller.hpp"
#include "services/service_host.hpp"
#include "services/waiting_callers.hpp"

namespace hgros {
namespace {

using Kind = CallFailure::Kind;

constexpr std::chrono::seconds kLateAnnouncements{10};
constexpr std::chrono::milliseconds kTwiceFor{500};  // A server that goes elsewhere may be announced in both places.
constexpr std::string_view kRequests = "hgros/call/";
constexpr std::string_view kReplies = "hgros/reply/";

Kind KindOf(CallMessage::Outcome outcome) {
  switch (outcome) {
    case CallMessage::Outcome::kFull: return Kind::kFull;
    case CallMessage::Outcome::kEnded: return Kind::kServerGone;
    case CallMessage::Outcome::kNotWritable: return Kind::kNotWritable;
    case CallMessage::Outcome::kTypeMismatch: return Kind::kTypeMismatch;
    case CallMessage::Outcome::kOk:
    case CallMessage::Outcome::kHandlerFailed: break;
  }
  return Kind::kHandlerFailed;
}

}  // namespace

CallEnd EndAs(const CallEnd& end, const TypeInfo& type) {
  if (!end.reply || end.type == nullptr || IsSameType(*end.type, type)) return end;
  CallEnd converted = end;
  converted.reply = ConvertMessage(end.reply, *end.type, type);
  if (converted.reply) {
    converted.type = &type;
  } else {
    converted.failure = {Kind::kNotWritable, "The reply of type " + end.type->name + " does not parse as " + type.name +
                                                 ", or cannot be written."};
  }
  return converted;
}

std::string RequestChannel(std::string_view service) { return std::string(kRequests) + std::string(service); }
std::string ReplyChannel(std::string_view service, SessionId caller) {
  return std::string(kReplies) + caller.ToString() + "/" + std::string(service);
}
bool IsRequestChannel(std::string_view channel) { return channel.starts_with(kRequests); }
bool IsReplyChannel(std::string_view channel) { return channel.starts_with(kReplies); }
std::string TurnChannel(std::string_view service) { return "hgros/serve/" + std::string(service); }

void RequireServiceName(std::string_view service) {
  if (const std::string fault = ChannelNameFault(service); !fault.empty()) RequireChannelName(service);
  const std::size_t longest = kMaxChannelNameLength - ReplyChannel("", SessionId{}).size();
  if (service.size() <= longest) return;
  throw Error("\"" + std::string(service) + "\" cannot name a service: it has " + std::to_string(service.size()) +
                  " bytes, and its channels leave room for " + std::to_string(longest) + ".",
              {}, "Give it a shorter name.");
}

Services::Services(ServicePlace& place, SessionId id, std::shared_ptr<Log> log)
    : id_(id),
      log_(std::move(log)),
      calls_(std::make_shared<CallTable>(fork_, log_)),
      waiting_callers_(std::make_shared<WaitingCallers>()),
      place_(&place) {}

Services::~Services() = default;

void Services::With(const std::function<void(ServicePlace&)>& use) {
  const std::shared_lock lock(place_mutex_);
  if (place_ != nullptr) use(*place_);
}

void Services::Post(std::function<void()> errand) {
  const std::scoped_lock lock(thread_mutex_);
  if (MakeThread()) thread_->Post(std::move(errand));
}

void Services::PostAt(std::chrono::steady_clock::time_point when, std::function<void()> errand) {
  const std::scoped_lock lock(thread_mutex_);
  if (MakeThread()) thread_->PostIn(when - std::chrono::steady_clock::now(), std::move(errand));
}

bool Services::MakeThread() {
  if (thread_ended_) return false;
  if (thread_) return true;
  try {
    thread_.emplace(log_);
  } catch (const Error& error) {
    thread_.reset();
    log_->WriteLimited(LogLevel::kError, "services thread",
                       std::string("Services and calls cannot react to other sessions. ") + error.what());
  }
  return thread_.has_value();
}

std::shared_ptr<ServiceHost> Services::HostOf(std::string_view name) const {
  const std::shared_lock lock(mutex_);
  const auto found = hosts_.find(name);
  return found == hosts_.end() || !found->second->started() ? nullptr : found->second;
}

void Services::AwaitWiring() const { const std::scoped_lock wiring(wiring_mutex_); }

std::vector<std::shared_ptr<ServiceCaller>> Services::Clients() const {
  AwaitWiring();  // A client that is being wired gets peer events before it is in the list.
  std::vector<std::shared_ptr<ServiceCaller>> all;
  const std::shared_lock lock(mutex_);
  for (const auto& [name, client] : clients_) all.push_back(client);
  return all;
}

std::vector<std::shared_ptr<ServiceHost>> Services::Hosts() const {
  std::vector<std::shared_ptr<ServiceHost>> all;
  const std::shared_lock lock(mutex_);
  for (const auto& [name, host] : hosts_) all.push_back(host);
  return all;
}

std::vector<ServiceSnapshot> Services::Snapshot() const {
  std::vector<ServiceSnapshot> all;
  for (const auto& host : Hosts()) all.push_back(host->Counts());
  return all;
}

std::shared_ptr<ServiceHost> Services::Serve(ServiceSetting setting, NodeOptions options, const CallSite& where) {
  RequireServiceName(setting.name);
  const std::string name = setting.name;
  if (options.executor.kind() == Executor::Kind::kPolled) {
    throw Error("Service \"" + name + "\" cannot be polled: nobody would run its handler.", where.ToString(),
                "Choose another executor; Executor::Polled() is for subscriptions.");
  }
  auto host = std::make_shared<ServiceHost>(std::move(setting), shared_from_this());
  {
    const std::scoped_lock lock(mutex_);
    if (refusing_) throw Error("The session is shutting down.");
    if (!hosts_.emplace(name, host).second) {
      throw Error("This session already serves \"" + name + "\".", {where.ToString()},
                  "End the other Service first, or give one of them another name.");
    }
  }
  try {
    host->Start(std::move(options), where);
  } catch (...) {
    host->End();
    throw;
  }
  waiting_callers_->Add(host);
  waiting_callers_->Nudge();
  OnAnnouncements();
  std::shared_ptr<ServiceCaller> client;
  {
    const std::shared_lock lock(mutex_);
    if (const auto found = clients_.find(name); found != clients_.end()) client = found->second;
  }
  if (client) client->HandOver(*host);
  return host;
}

void Services::Forget(const ServiceHost& host) {
  waiting_callers_->Remove(host);
  const std::scoped_lock lock(mutex_);
  const auto found = hosts_.find(host.setting().name);
  if (found != hosts_.end() && found->second.get() == &host) hosts_.erase(found);
  second_servers_.erase(host.setting().name);
}

std::shared_ptr<ServiceCaller> Services::ClientOf(std::string_view name, const Request& request) {
  const auto find = [&]() -> std::shared_ptr<ServiceCaller> {
    const std::shared_lock lock(mutex_);
    const auto found = clients_.find(name);
    return found == clients_.end() ? nullptr : found->second;
  };
  if (auto known = find()) return known;
  const std::scoped_lock wiring(wiring_mutex_);
  if (auto known = find()) return known;
  auto client = std::make_shared<ServiceCaller>(std::string(name), request.request, request.reply, shared_from_this());
  client->Start();
  const std::scoped_lock lock(mutex_);
  clients_.emplace(std::string(name), client);
  return client;
}

std::shared_ptr<PendingCall> Services::Call(std::string_view name, Request request, AnyAnswer callback) {
  RequireServiceName(name);
  if (callback && !request.answers_inline) OpenAnswers();
  auto call = std::make_shared<CallState>(std::string(name), calls_, waiting_callers_, std::move(callback),
                                          request.answers_inline);
  call->timeout = request.timeout;
  call->message = std::make_shared<CallMessage>();
  call->message->caller = id_.value;
  if (!IsAnyType(request.reply)) call->message->reply_type = request.reply.name;
  call->message->patience_ns =
      request.timeout == std::chrono::nanoseconds::max() ? 0 : std::max<std::int64_t>(request.timeout.count(), 1);
  call->message->body = std::move(request.body);
  call->message->type = &request.body_type;
  call->message->cause = Cause::Here();
  if (!call->message->body) {
    call->Refuse({Kind::kNotWritable, "The call of service \"" + std::string(name) + "\" has no request."});
    return call;
  }
  try {
    if (!calls_->Begin(call, request.timeout)) {
      call->Refuse(calls_->closed() ? CallFailure{Kind::kClosed, "The session is shutting down."}
                                    : CallFailure{Kind::kFull, std::to_string(CallTable::kMaxCalls) +
                                                                   " calls of this session are pending already."});
      return call;
    }
  } catch (const Error& error) {  // No thread can be started.
    call->Refuse({Kind::kFull, error.what()});
    return call;
  }
  try {
    Dispatch(call, request);
  } catch (const Error& error) {  // The session is shutting down.
    calls_->End(call->number, Failed(Kind::kClosed, error.what()));
  }
  return call;
}

void Services::Dispatch(const std::shared_ptr<CallState>& call, const Request& request) {
  const auto differ = [&](const TypeInfo& their_request, const TypeInfo& their_reply, const std::string& who) {
    calls_->End(call->number,
                Failed(Kind::kTypeMismatch, "Service \"" + call->service() + "\" is called with " +
                                                request.request.name + " for " + request.reply.name + ", but " + who +
                                                " with " + their_request.name + " for " + their_reply.name + "."));
  };
  if (const auto host = HostOf(call->service())) {
    if (!host->Fits(request.request, request.reply)) {
      return differ(*host->setting().request, *host->setting().reply, "this session serves it");
    }
    if (call->GoesTo(host)) host->Arrive(call->message);
    return;
  }
  const auto client = ClientOf(call->service(), request);
  if (!AreInterchangeable(client->request(), request.request) || !AreInterchangeable(client->reply(), request.reply)) {
    return differ(client->request(), client->reply(), "this session has called it");
  }
  client->Send(call);
}

void Services::OpenAnswers() {
  const std::scoped_lock wiring(wiring_mutex_);
  if (answers_.active()) return;
  With([this](ServicePlace& place) {
    const std::string channel = "hgros/answers";
    NodeOptions options;
    options.name = channel;
    options.queue = Queue::KeepAll(CallTable::kMaxCalls);
    answers_ = place.Graph().FromGraph<AnsweredCall>(
        channel, Invoke::kConcurrent,
        [calls = calls_](const AnsweredCall& answered) {
          calls->Answered();
          calls->RunCallback(answered);
        },
        std::move(options));
    calls_->SetAnswers(place.Graph().Advertise<AnsweredCall>(channel));
  });
}

void Services::EndCall(const CallMessage& reply, const std::string& service) {
  if (reply.outcome == CallMessage::Outcome::kOk && reply.body) {
    calls_->End(reply.call, {reply.body, {}, reply.type});
    return;
  }
  const Kind kind = KindOf(reply.outcome);
  calls_->End(reply.call,
              Failed(kind, kind == Kind::kNotWritable ? "Service \"" + service + "\": " + reply.text : reply.text));
}

std::string Services::WhyNoReply(const std::string& service) {
  ReplyWays ways{.offered = 1};
  const std::string channel = RequestChannel(service);
  With([&](ServicePlace& place) { ways = place.WaysOf(service); });
  if (ways.offered > 0) return {};
  if (!ways.enter) {
    return " Replies cannot reach this session: no subscriber endpoint has \"" + channel +
           "\" in its list of channels. Add it.";
  }
  return " Nobody offers its replies here. If the server runs, check that a subscriber endpoint here reaches its "
         "publisher endpoint, and that \"" +
         channel + "\" is in their lists of channels.";
}

void Services::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  Post([weak = weak_from_this(), peer, why = std::string(reason)] {
    const auto self = weak.lock();
    if (!self) return;
    for (const auto& client : self->Clients()) client->OnPeerGone(peer, why);
    for (const auto& host : self->Hosts()) host->OnPeerGone(peer.id);
  });
}

void Services::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view sentence) noexcept {
  Post([weak = weak_from_this(), channel = std::string(channel), id = peer.id, what = std::string(sentence)] {
    const auto self = weak.lock();
    if (!self) return;
    for (const auto& client : self->Clients()) client->OnMisfit(channel, id, what);
  });
}

void Services::OnAnnouncements() noexcept {
  {
    const std::shared_lock lock(mutex_);
    if (hosts_.empty() && clients_.empty()) return;
  }
  Post([weak = weak_from_this()] {
    const auto self = weak.lock();
    if (!self) return;
    self->LookForSecondServers();
    for (const auto& client : self->Clients()) client->Update();
  });
}

void Services::TakeFrom(SessionId other) {
  const std::scoped_lock lock(mutex_);
  taken_from_[other] = DeadlineIn(kLateAnnouncements);
}

void Services::LookForSecondServers() {
  for (const auto& host : Hosts()) {
    const std::string& name = host->setting().name;
    ChannelSearch search;
    With([&](ServicePlace& place) { search = place.Search(RequestChannel(name)); });
    {
      const std::scoped_lock lock(mutex_);
      std::erase_if(taken_from_, [](const auto& one) { return one.second < std::chrono::steady_clock::now(); });
      std::erase_if(search.announced, [this](const PeerInfo& one) { return taken_from_.contains(one.id); });
    }
    const auto now = std::chrono::steady_clock::now();
    std::unique_lock lock(mutex_);
    if (search.announced.empty()) {
      second_servers_.erase(name);
      continue;
    }
    const PeerInfo& other = search.announced.front();
    SecondServer& second = second_servers_[name];
    if (second.session != other.id) {
      second = {other.id, now};
      lock.unlock();
      PostAt(now + kTwiceFor, [weak = weak_from_this()] {
        if (const auto self = weak.lock()) self->LookForSecondServers();
      });
      continue;
    }
    if (now < second.since + kTwiceFor || std::exchange(second.said, true)) continue;
    lock.unlock();
    std::string sentence = "Service \"" + name + "\" is served here and by session " + other.name() +
                           ". Each caller uses the one that it found first. Give one of them another name.";
    log_->WriteLimited(LogLevel::kWarning, "served twice " + name, sentence);
    With([&](ServicePlace& place) { place.ReportServedTwice(other, RequestChannel(name), std::move(sentence)); });
  }
}

void Services::Refuse() {
  {
    const std::scoped_lock lock(mutex_);
    refusing_ = true;
  }
  for (const auto& host : Hosts()) host->Refuse();
  calls_->Close();
}

void Services::Close() {
  {
    const std::scoped_lock lock(thread_mutex_);
    thread_ended_ = true;
  }
  if (thread_) thread_->End();
  {
    const std::unique_lock lock(place_mutex_);
    place_ = nullptr;
  }
  std::map<std::string, std::shared_ptr<ServiceCaller>, std::less<>> clients;
  {
    const std::scoped_lock lock(mutex_);
    clients.swap(clients_);
  }
}

}  // namespace hgros
