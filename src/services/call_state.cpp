#include "services/call_state.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/thread_local.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/services/services.hpp"
#include "services/call_table.hpp"
#include "services/service_caller.hpp"
#include "services/service_host.hpp"

namespace hgros {
namespace {

// While a thread waits, it may run a handler that waits in turn. Each level uses stack.
constexpr int kMaxNestedRequests = 16;
// A server offers its replies when the first request comes. After this time, the offer should be known.
constexpr auto kTimeForAnOffer = std::chrono::milliseconds(100);
HGROS_THREAD_LOCAL int nested_requests = 0;

}  // namespace

CallEnd Failed(CallFailure::Kind kind, std::string reason) { return {nullptr, {kind, std::move(reason)}}; }

CallEnd NotWritten(const std::string& service, PublishStatus status) {
  return Failed(CallFailure::Kind::kNotWritable, "The request of service \"" + service +
                                                     "\" could not be written: " + std::string(ToString(status)) + ".");
}

std::string InWords(std::chrono::nanoseconds time) {
  time = std::max(time, std::chrono::nanoseconds::zero());
  if (time < std::chrono::milliseconds(1)) return std::to_string(time.count() / 1000) + " us";
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) + " ms";
}

CallState::CallState(std::string service, std::shared_ptr<CallTable> table,
                     std::shared_ptr<WaitingCallers> waiting_callers, AnyAnswer callback, bool answers_inline)
    : may_be_waited_for_(!callback && !DataGraph::InCallback()),
      service_(std::move(service)),
      table_(std::move(table)),
      waiting_callers_(std::move(waiting_callers)),
      callback_(std::move(callback)),
      answers_inline_(answers_inline) {}

void CallState::Finish(CallEnd end) { Finish(std::unique_lock(mutex_), std::move(end)); }

// One lock for both steps, so that no server is found after the reason is chosen and before the call ends.
void CallState::FinishOverdue() {
  // Asks the session, so it is done before the lock.
  const auto reached = client();
  const auto services = reached ? reached->services() : nullptr;
  const bool sent = has_server();
  const bool served = reached && reached->HasServer();
  std::string hint;
  if (reached && !sent && !served) hint = reached->Suggestion();
  if (services && sent && Age() >= kTimeForAnOffer) hint = services->WhyNoReply(service_);
  std::unique_lock lock(mutex_);
  CallEnd end = Overdue(served, hint);
  Finish(std::move(lock), std::move(end));
}

void CallState::Finish(std::unique_lock<std::mutex> lock, CallEnd end) {
  if (done()) return;
  end_ = std::move(end);
  AnyAnswer callback = std::move(callback_);
  done_.store(true, std::memory_order_release);
  lock.unlock();
  changed_.notify_all();
  if (!callback) return;
  AnsweredCall answered{service_, std::move(callback), end_};
  if (answers_inline_) return table_->RunCallback(answered);
  table_->Answer(std::make_shared<const AnsweredCall>(std::move(answered)));
}

void CallState::Refuse(CallFailure failure) { Finish({nullptr, std::move(failure)}); }

void CallState::Nudge() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    nudged_ = true;
  }
  changed_.notify_all();
}

const CallEnd& CallState::Wait() {
  if (!done()) {
    if (DataGraph::InCallback()) {
      RunRequestsWhileWaiting();
    } else if (const auto reached = client()) {
      reached->AwaitQuickly(*this);
    }
  }
  if (!done()) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return done(); });
  }
  return end_;
}

void CallState::RunRequestsWhileWaiting() {
  const auto own = host();
  waiting_callers_->Enter(*this);
  for (;;) {
    {
      const std::scoped_lock lock(mutex_);
      nudged_ = false;
    }
    if (done()) break;
    if (own && own->RunOneRequest(number)) continue;
    if (done()) break;
    if (own && own->HoldsUpThisThread()) {
      table_->End(number, Failed(CallFailure::Kind::kWouldDeadlock,
                                 "A handler of service \"" + service_ +
                                     "\" waits for a call to its own service, which handles one request at a time. "
                                     "Let it handle several at once, or get the reply in a callback."));
      own->Withdraw(message->caller, number);
      break;
    }
    if (nested_requests < kMaxNestedRequests) {
      ++nested_requests;
      const bool ran = waiting_callers_->RunOne();
      --nested_requests;
      if (ran) continue;
    }
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return done() || nudged_; });
  }
  waiting_callers_->Leave(*this);
}

void CallState::Cancel() noexcept {
  if (done() || table_->in_forked_child()) return;
  const bool ended = table_->End(
      number, Failed(CallFailure::Kind::kCancelled, "The call of service \"" + service_ + "\" was cancelled."));
  if (!ended) return;
  std::shared_ptr<ServiceHost> host;
  std::shared_ptr<ServiceCaller> client;
  {
    const std::scoped_lock lock(mutex_);
    host = host_.lock();
    client = client_.lock();
  }
  if (host) host->Withdraw(message->caller, number);
  if (client) client->Withdraw(*this);
}

bool CallState::GoesTo(const std::shared_ptr<ServiceHost>& host) {
  const std::scoped_lock lock(mutex_);
  if (done()) return false;
  host_ = host;
  server_ = SessionId{message->caller};
  return true;
}

bool CallState::GoesTo(const std::shared_ptr<ServiceCaller>& client, SessionId server, std::uint64_t ends_before) {
  const std::scoped_lock lock(mutex_);
  if (done()) return false;
  client_ = client;
  server_ = server;
  ends_before_ = ends_before;
  return true;
}

void CallState::AwaitsServerOf(const std::shared_ptr<ServiceCaller>& client) {
  const std::scoped_lock lock(mutex_);
  client_ = client;
  server_ = {};
}

bool CallState::IsOf(const ServiceCaller& client) const {
  const std::scoped_lock lock(mutex_);
  return client_.lock().get() == &client;
}

std::shared_ptr<ServiceHost> CallState::host() const {
  const std::scoped_lock lock(mutex_);
  return host_.lock();
}

std::shared_ptr<ServiceCaller> CallState::client() const {
  const std::scoped_lock lock(mutex_);
  return client_.lock();
}

SessionId CallState::server() const {
  const std::scoped_lock lock(mutex_);
  return server_;
}
std::uint64_t CallState::ends_before() const {
  const std::scoped_lock lock(mutex_);
  return ends_before_;
}

bool CallState::has_server() const { return server() != SessionId{}; }

CallEnd CallState::Overdue(bool served, const std::string& hint) const {
  if (server_ != SessionId{}) {
    return Failed(CallFailure::Kind::kTimedOut,
                  "Service \"" + service_ + "\" did not reply within " + InWords(timeout) + "." + hint);
  }
  if (served) {
    return Failed(CallFailure::Kind::kFull, "The server of \"" + service_ + "\" has taken no more requests within " +
                                                InWords(timeout) + ": too many wait.");
  }
  return Failed(CallFailure::Kind::kNoServer,
                "No server of \"" + service_ + "\" was found within " + InWords(timeout) + "." + hint);
}

}  // namespace hgros
