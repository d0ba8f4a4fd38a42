#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/codec/run_time_type.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/services/services.hpp"
#include "services/reply_line.hpp"

namespace hgros {

// The empty message that gives the handler's node one turn. Each turn takes the next request.
struct ServiceTurn {};

// A service that this session offers. Requests wait in a queue of the service. Each request gives the node one turn,
// and each turn runs one request. A thread that waits inside a callback may run a request instead; then one turn finds
// no work.
//
// Thread safety: all functions.
// Invariants: under kSerial one request is handled at a time, on any thread. A turn that comes meanwhile is counted in
// owed_ and repeated afterwards. Every accepted request is answered: by its handler, or when the service ends.
class ServiceHost : public std::enable_shared_from_this<ServiceHost> {
 public:
  // Number of requests that may wait if the options set no lossless queue.
  static constexpr std::size_t kDefaultQueue = 16384;

  ServiceHost(ServiceSetting setting, const std::shared_ptr<Services>& services);

  // Wires the service. Throws Error. Until it returns, calls of this session go to other servers.
  void Start(NodeOptions options, const CallSite& where);
  // Ends the service as ~Service() promises.
  void End();
  // For the end of the session: refuses new requests, and answers those that wait.
  void Refuse();
  [[nodiscard]] bool ended() const;
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_->IsChild(); }
  [[nodiscard]] bool started() const noexcept { return started_.load(std::memory_order_acquire); }

  // A request of this session. Another session's has its `credit`: it ends when the request leaves the queue, so that
  // the caller's window limits what waits.
  void Arrive(std::shared_ptr<const CallMessage> request, std::shared_ptr<const void> credit = nullptr);
  // The caller no longer waits for this call: its request or its reply need not wait either.
  void Withdraw(std::uint64_t caller, std::uint64_t call);
  // For a thread that waits inside a callback: runs the request of `own_call`, or any request if it is empty. False if
  // there is none, or the executor is dedicated.
  bool RunOneRequest(std::optional<std::uint64_t> own_call = std::nullopt);
  // True if this thread runs a handler of this service and no other thread can run one meanwhile.
  [[nodiscard]] bool HoldsUpThisThread() const;

  void OnPeerGone(SessionId peer);
  [[nodiscard]] NodeSnapshot stats() const { return node_.stats(); }
  [[nodiscard]] ServiceSnapshot Counts() const { return {setting_.name, unhandled_, dropped_replies_}; }
  [[nodiscard]] const ServiceSetting& setting() const noexcept { return setting_; }
  [[nodiscard]] bool Fits(const TypeInfo& request, const TypeInfo& reply) const noexcept {
    return AreInterchangeable(*setting_.request, request) && AreInterchangeable(*setting_.reply, reply);
  }

 private:
  struct Waiting {
    std::shared_ptr<const CallMessage> request;
    std::optional<std::chrono::steady_clock::time_point> due;
    Cause cause;
    std::shared_ptr<const void> credit;
    std::size_t bytes = 0;  // Of another session's request.
  };
  class Running;  // Marks a thread that runs a handler.

  void OnRequest(const std::shared_ptr<const CallMessage>& request, const MessageInfo& info);
  // Runs one request. False if there is none, or another one is being handled.
  bool Turn(std::optional<std::uint64_t> own_call, bool helps);
  void Handle(const Waiting& waiting);
  void Answer(const CallMessage& request, CallMessage::Outcome outcome, const std::string& text,
              AnyMessage reply = nullptr, std::optional<std::chrono::steady_clock::time_point> due = std::nullopt);
  // Why the queue takes no request of so many bytes; empty if it does. Under mutex_.
  [[nodiscard]] std::string WhyFull(std::size_t bytes) const;
  // Removes it from the queue. Under mutex_.
  Waiting Take(std::deque<Waiting>::iterator request);
  // Null if the caller has sent no request, or is gone.
  [[nodiscard]] std::shared_ptr<ReplyLine> LineTo(SessionId caller) const;
  // Opens the line if there is none. Called by the thread that receives requests, one at a time.
  [[nodiscard]] std::shared_ptr<ReplyLine> OpenLine(SessionId caller);
  [[nodiscard]] ReplyLine::Means MeansOf(SessionId caller);
  void Flush(SessionId caller);

  AnyHandler handler_;  // Destroyed when the service has ended and runs no request, by the thread that sees it first.
  const ServiceSetting setting_;
  const std::weak_ptr<Services> services_;
  const std::shared_ptr<const ForkGuard> fork_;
  const SessionId session_;
  const std::shared_ptr<Log> log_;
  const std::shared_ptr<ServiceRoom> room_ = ServiceRoom::OfFreeMemory();
  std::size_t limit_ = kDefaultQueue;
  Executor::Kind executor_ = Executor::Kind::kTbb;
  const std::shared_ptr<const ServiceTurn> turn_ = std::make_shared<const ServiceTurn>();
  Publisher<ServiceTurn> turns_;
  std::atomic<bool> started_{false};
  std::atomic<std::uint64_t> unhandled_{0};
  std::atomic<std::uint64_t> dropped_replies_{0};

  mutable std::mutex mutex_;
  std::condition_variable idle_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;  // Of other sessions' requests.
  bool ended_ = false;
  bool serial_busy_ = false;
  std::size_t owed_ = 0;  // Turns that came while a request was being handled.
  std::size_t running_ = 0;
  bool left_ = false;  // The service was ended inside a callback while it ran a request.
  std::map<std::uint64_t, std::shared_ptr<ReplyLine>> lines_;  // By caller.
  // Written only by Start() and End().
  Subscription node_;
  Subscription requests_;
};

}  // namespace hgros
