#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "hgros/base/ids.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/internal/codec/call_message.hpp"
#include "hgros/services/call_future.hpp"
#include "services/waiting_callers.hpp"

namespace hgros {

class CallTable;
class ServiceCaller;

// A callback to call, its argument, and the service that was called.
struct AnsweredCall {
  std::string service;
  AnyAnswer callback;
  CallEnd end;
};

// One call of this session.
//
// Thread safety: all functions. Invariants: it ends once, and the result never changes afterwards. It keeps its table
// alive because its future may outlive the session.
class CallState final : public PendingCall,
                        public WaitingCallers::Caller,
                        public std::enable_shared_from_this<CallState> {
 public:
  CallState(std::string service, std::shared_ptr<CallTable> table, std::shared_ptr<WaitingCallers> waiting_callers,
            AnyAnswer callback, bool answers_inline);

  const CallEnd& Wait() override;
  [[nodiscard]] bool done() const noexcept override { return done_.load(std::memory_order_acquire); }
  void Cancel() noexcept override;
  void Nudge() noexcept override;

  // Called by the table. Runs no callback under a lock.
  void Finish(CallEnd end);
  // Its timeout has expired.
  void FinishOverdue();
  // Ends it before it is in the table.
  void Refuse(CallFailure failure);

  // Sets the receiver before the call is sent. False if the call has ended: then it must not be sent, because the
  // caller may have been told that no server got it.
  [[nodiscard]] bool GoesTo(const std::shared_ptr<ServiceHost>& host);
  // `ends_before`: how often a server has ended the service before.
  [[nodiscard]] bool GoesTo(const std::shared_ptr<ServiceCaller>& client, SessionId server, std::uint64_t ends_before);
  void AwaitsServerOf(const std::shared_ptr<ServiceCaller>& client);
  [[nodiscard]] bool IsOf(const ServiceCaller& client) const;
  [[nodiscard]] SessionId server() const;
  [[nodiscard]] std::uint64_t ends_before() const;
  [[nodiscard]] bool has_server() const;

  // True if the calling thread was not inside a callback, so that it may block.
  [[nodiscard]] bool may_be_waited_for() const noexcept { return may_be_waited_for_; }
  [[nodiscard]] std::chrono::nanoseconds Age() const { return std::chrono::steady_clock::now() - begun_; }
  [[nodiscard]] const std::string& service() const noexcept { return service_; }
  std::uint64_t number = 0;  // Set by the table, before other threads see the call; `due`, too.
  std::optional<std::chrono::steady_clock::time_point> due;
  std::chrono::nanoseconds timeout{0};
  std::shared_ptr<CallMessage> message;  // The request; immutable once it is sent.

 private:
  void Finish(std::unique_lock<std::mutex> lock, CallEnd end);
  // Under the lock. `served`: another session serves it. `hint`: more about the reason.
  [[nodiscard]] CallEnd Overdue(bool served, const std::string& hint) const;
  void RunRequestsWhileWaiting();
  [[nodiscard]] std::shared_ptr<ServiceHost> host() const;
  [[nodiscard]] std::shared_ptr<ServiceCaller> client() const;

  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  const bool may_be_waited_for_;
  const std::string service_;
  const std::shared_ptr<CallTable> table_;
  const std::shared_ptr<WaitingCallers> waiting_callers_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  AnyAnswer callback_;
  const bool answers_inline_;
  std::atomic<bool> done_{false};
  bool nudged_ = false;
  CallEnd end_;
  std::weak_ptr<ServiceHost> host_;
  std::weak_ptr<ServiceCaller> client_;
  SessionId server_;
  std::uint64_t ends_before_ = 0;
};

// A failure as the end of a call.
[[nodiscard]] CallEnd Failed(CallFailure::Kind kind, std::string reason);
[[nodiscard]] CallEnd NotWritten(const std::string& service, PublishStatus status);
// "500 ms".
[[nodiscard]] std::string InWords(std::chrono::nanoseconds time);

}  // namespace hgros
