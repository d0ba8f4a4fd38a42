#include "services/service_host.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/delivered_credit.hpp"
#include "hgros/graph/ready_node_slot.hpp"
#include "hgros/services/handled_request.hpp"
#include "services/waiting_callers.hpp"

namespace hgros {
namespace {

// How many requests of one caller may be on their way.
constexpr std::size_t kMoreThanFit = 64;
constexpr std::size_t kLeastInFlight = 1024;
constexpr std::size_t kMostInFlight = 65536;

}  // namespace

class ServiceHost::Running {
 public:
  explicit Running(const ServiceHost& host) : host_(host), outer_(std::exchange(innermost, this)) {}
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() { innermost = outer_; }

  [[nodiscard]] static bool Here(const ServiceHost& host) {
    const Running* one = innermost;
    while (one != nullptr && &one->host_ != &host) one = one->outer_;
    return one != nullptr;
  }

 private:
  static inline HGROS_THREAD_LOCAL const Running* innermost = nullptr;
  const ServiceHost& host_;
  const Running* const outer_;
};

ServiceHost::ServiceHost(ServiceSetting setting, const std::shared_ptr<Services>& services)
    : handler_(std::exchange(setting.handler, nullptr)),
      setting_(std::move(setting)),
      services_(services),
      fork_(services->fork()),
      session_(services->id()),
      log_(services->log()) {}

void ServiceHost::Start(NodeOptions options, const CallSite& where) {
  const auto services = services_.lock();
  if (options.name.empty()) options.name = setting_.name;
  if (!options.queue.lossless()) options.queue = Queue::KeepAll(kDefaultQueue);
  const auto self = shared_from_this();
  services->With([&](ServicePlace& place) {
    const std::string channel = TurnChannel(setting_.name);
    turns_ = place.Graph().Advertise<ServiceTurn>(channel, 0, where);
    node_ = place.Graph().FromGraph<ServiceTurn>(
        channel, setting_.invoke, [self](const ServiceTurn&) { self->Turn(std::nullopt, false); }, options, where);
    const NodeSnapshot node = node_.stats();
    if (!node.queue.lossless()) {
      node_.Reset();
      throw Error("The node \"" + node.name + "\" runs service \"" + setting_.name +
                      "\", but the queue in its configuration drops requests.",
                  {}, "Set `queue: {keep_all: N}`, or remove the queue setting.");
    }
    limit_ = node.queue.depth();
    executor_ = node.executor.kind();
    requests_ = place.Listen(
        RequestChannel(setting_.name), *setting_.request,
        [self](const AnyMessage& message, const MessageInfo& info) {
          self->OnRequest(std::static_pointer_cast<const CallMessage>(message), info);
        },
        // A request counts as on its way until it leaves the queue. One more must come, to be told that it is full.
        std::clamp<std::size_t>(limit_ + kMoreThanFit, kLeastInFlight, kMostInFlight));
  });
  started_.store(true, std::memory_order_release);
}

void ServiceHost::OnRequest(const std::shared_ptr<const CallMessage>& request, const MessageInfo& info) {
  // A session cannot call in the name of another one. A request that names another server is for that server.
  if (!info.remote || request->caller != info.id.publisher) return;
  if (request->server != 0 && request->server != session_.value) return;
  if (request->cancelled) {
    Withdraw(request->caller, request->call);
    return;
  }
  // Opened before the request is handled, so that the caller's subscription to the replies arrives meanwhile.
  if (!OpenLine(SessionId{request->caller})) return;
  if (executor_ == Executor::Kind::kTbb) {
    const ReadyNodeSlot::Opened opened;
    Arrive(request, DeliveredCredit::Here());
  } else {
    Arrive(request,
           DeliveredCredit::Here());  // An inline handler is user code and may wait for a node that it makes ready.
  }
}

void ServiceHost::Arrive(std::shared_ptr<const CallMessage> request, std::shared_ptr<const void> credit) {
  using Outcome = CallMessage::Outcome;
  if (request->outcome != Outcome::kOk) return Answer(*request, request->outcome, request->text);
  if (!request->reply_type.empty() && request->reply_type != setting_.reply->name) {
    return Answer(*request, Outcome::kTypeMismatch,
                  "Service \"" + setting_.name + "\" replies with " + setting_.reply->name + ", not with " +
                      request->reply_type + ".");
  }
  // A request of this session has come directly, perhaps from another thread than the caller's.
  Waiting waiting{request, std::nullopt, request->cause.message == 0 ? Cause::Here() : request->cause,
                  std::move(credit), 0};
  if (request->caller != session_.value) waiting.bytes = BytesOf(*request);
  if (request->patience_ns > 0) waiting.due = DeadlineIn(std::chrono::nanoseconds(request->patience_ns));
  bool ended = false;
  std::string full;
  {
    const std::scoped_lock lock(mutex_);
    ended = ended_;
    full = WhyFull(waiting.bytes);
    if (!ended && full.empty()) {
      waiting_bytes_ += waiting.bytes;
      waiting_.push_back(std::move(waiting));
    }
  }
  if (ended) return Answer(*request, Outcome::kEnded, "Service \"" + setting_.name + "\" has ended.");
  if (!full.empty()) {
    return Answer(*request, Outcome::kFull, "Service \"" + setting_.name + "\" has " + full + " waiting already.");
  }
  // If the queue of turns is full, it holds more turns than there are requests.
  turns_(turn_);
  if (const auto services = services_.lock()) services->waiting_callers()->Nudge();
}

std::string ServiceHost::WhyFull(std::size_t bytes) const {
  if (waiting_.size() >= limit_) return std::to_string(limit_) + " requests";
  if (waiting_bytes_ == 0 || waiting_bytes_ + bytes <= room_->service_bytes) return {};
  return std::to_string(waiting_bytes_ >> 20U) + " MiB of requests";
}

ServiceHost::Waiting ServiceHost::Take(std::deque<Waiting>::iterator request) {
  Waiting taken = std::move(*request);
  waiting_.erase(request);
  waiting_bytes_ -= taken.bytes;
  return taken;
}

void ServiceHost::Withdraw(std::uint64_t caller, std::uint64_t call) {
  Waiting dropped;  // Destroyed after the lock: a message's destructor is user code.
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find_if(
        waiting_, [&](const Waiting& one) { return one.request->caller == caller && one.request->call == call; });
    if (found != waiting_.end()) {
      dropped = Take(found);
      ++unhandled_;
      return;
    }
  }
  if (const auto line = LineTo(SessionId{caller}); line && line->Withdraw(call)) ++dropped_replies_;
}

bool ServiceHost::RunOneRequest(std::optional<std::uint64_t> own_call) {
  return executor_ != Executor::Kind::kDedicated && Turn(own_call, true);
}

bool ServiceHost::HoldsUpThisThread() const {
  const bool one_at_a_time = setting_.invoke == Invoke::kSerial || executor_ == Executor::Kind::kDedicated;
  return one_at_a_time && Running::Here(*this);
}

bool ServiceHost::Turn(std::optional<std::uint64_t> own_call, bool helps) {
  Waiting next;
  {
    const std::scoped_lock lock(mutex_);
    if (setting_.invoke == Invoke::kSerial && serial_busy_) {
      if (!helps) ++owed_;
      return false;
    }
    auto found = waiting_.begin();
    if (own_call) {
      found = std::ranges::find_if(waiting_, [&](const Waiting& one) {
        return one.request->caller == session_.value && one.request->call == *own_call;
      });
    }
    if (found == waiting_.end()) return false;
    next = Take(found);
    serial_busy_ = setting_.invoke == Invoke::kSerial;
    ++running_;
  }
  next.credit.reset();  // Not later: the handler may wait for a call that its own caller must make.
  Handle(next);
  next = {};
  bool again = false;
  bool more = false;
  bool idle = false;
  AnyHandler left;  // Destroyed after the lock.
  {
    const std::scoped_lock lock(mutex_);
    serial_busy_ = false;
    more = !waiting_.empty();
    again = owed_ > 0 && more;
    owed_ = more ? owed_ - (again ? 1 : 0) : 0;
    idle = --running_ == 0 && ended_;
    if (idle && left_) left = std::exchange(handler_, nullptr);
  }
  if (idle) idle_.notify_all();
  if (again) turns_(turn_);
  if (more) {  // A waiting thread may have given up because the handler was busy.
    if (const auto services = services_.lock()) services->waiting_callers()->Nudge();
  }
  return true;
}

void ServiceHost::Handle(const Waiting& waiting) {
  using Outcome = CallMessage::Outcome;
  const CallMessage& request = *waiting.request;
  const CauseScope cause(waiting.cause);
  if (waiting.due && *waiting.due <= std::chrono::steady_clock::now()) {  // The caller has reported the timeout.
    ++unhandled_;
    return;
  }
  AnyMessage reply;
  Outcome outcome = Outcome::kHandlerFailed;
  std::string text = "The handler gave no reply.";
  try {
    const Running here(*this);
    const HandledRequest handled(waiting.due);
    const AnyMessage body = ConvertMessage(request.body, *request.type, *setting_.request_body);
    if (!body) {
      return Answer(request, Outcome::kNotWritable,
                    "The request does not parse as " + setting_.request_body->name + ".");
    }
    reply = handler_(body);
    if (reply) outcome = Outcome::kOk;
  } catch (const NotHandled&) {
    if (!ended() && waiting.due && *waiting.due <= std::chrono::steady_clock::now()) {
      ++unhandled_;
      return;
    }
    outcome = Outcome::kEnded;
    text = "Service \"" + setting_.name + "\" has ended.";
  } catch (const std::exception& error) {
    text = error.what();
  } catch (const ForcedUnwind&) {
    throw;  // The node that runs the handler reports it.
  } catch (...) {
    text = "The handler threw something that is not a std::exception.";
  }
  if (reply) text.clear();
  Answer(request, outcome, text, std::move(reply), waiting.due);
}

void ServiceHost::Answer(const CallMessage& request, CallMessage::Outcome outcome, const std::string& text,
                         AnyMessage reply, std::optional<std::chrono::steady_clock::time_point> due) {
  auto answer = std::make_shared<CallMessage>();
  answer->caller = request.caller;
  answer->server = session_.value;
  answer->call = request.call;
  answer->outcome = outcome;
  answer->text = AsUtf8(text);
  answer->body = std::move(reply);
  answer->type = setting_.reply_body;
  answer->cause = Cause::Here();
  if (request.caller == session_.value) {
    if (const auto services = services_.lock()) services->EndCall(*answer, setting_.name);
    return;
  }
  const auto line = LineTo(SessionId{request.caller});
  if (!line || !line->Send(std::move(answer), due)) ++dropped_replies_;
}

void ServiceHost::OnPeerGone(SessionId peer) {
  std::shared_ptr<ReplyLine> line;
  std::deque<Waiting> dropped;
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = lines_.find(peer.value); found != lines_.end()) {
      line = std::move(found->second);
      lines_.erase(found);
    }
    for (auto one = waiting_.begin(); one != waiting_.end();) {
      if (one->request->caller != peer.value) {
        ++one;
        continue;
      }
      waiting_bytes_ -= one->bytes;
      dropped.push_back(std::move(*one));
      one = waiting_.erase(one);
      ++unhandled_;
    }
  }
  if (line) dropped_replies_ += line->Close();
  const auto services = services_.lock();
  if (!line || !services) return;
  services->With([&](ServicePlace& place) { place.CloseOutlet(ReplyChannel(setting_.name, peer), line->outlet()); });
}

bool ServiceHost::ended() const {
  const std::scoped_lock lock(mutex_);
  return ended_;
}

void ServiceHost::Refuse() {
  std::deque<Waiting> left;
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    left.swap(waiting_);
    waiting_bytes_ = 0;
  }
  for (const Waiting& one : left) {
    Answer(*one.request, CallMessage::Outcome::kEnded, "Service \"" + setting_.name + "\" has ended.");
  }
}

void ServiceHost::End() {
  AnyHandler handler;  // Destroyed here and last: other threads may keep this object a moment longer.
  Refuse();
  const auto services = services_.lock();
  if (services) services->Forget(*this);
  std::map<std::uint64_t, std::shared_ptr<ReplyLine>> lines;
  {
    std::unique_lock lock(mutex_);
    // Also for threads that ran a request while they were waiting.
    if (!DataGraph::InCallback()) idle_.wait(lock, [this] { return running_ == 0; });
    if (running_ == 0) {
      handler = std::exchange(handler_, nullptr);
    } else {
      left_ = true;
    }
  }
  node_.Reset();
  requests_.Reset();
  {
    const std::scoped_lock lock(mutex_);
    lines.swap(lines_);
  }
  if (!services) return;
  services->With([&](ServicePlace& place) {
    for (const auto& [caller, line] : lines) {
      place.CloseOutlet(ReplyChannel(setting_.name, SessionId{caller}), line->outlet());
    }
  });
}

}  // namespace hgros
