#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/services/call_result.hpp"

namespace hgros {

/// One call under way, without its type; what CallFuture and CallTicket hold. Thread-safe.
class HGROS_EXPORT PendingCall {
 public:
  virtual ~PendingCall() = default;
  /// Blocks until the call has ended.
  virtual const CallEnd& Wait() = 0;
  [[nodiscard]] virtual bool done() const noexcept = 0;
  virtual void Cancel() noexcept = 0;
};

/// The reply that is to come. Move-only. Dropping it cancels the call, since nobody could see what comes back.
///
/// Threading: thread-safe, except for moves and the destructor. May outlive its session, whose end ends the call.
template <class Reply>
class [[nodiscard("dropping the future cancels the call")]] CallFuture {
 public:
  explicit CallFuture(std::shared_ptr<PendingCall> call) : call_(std::move(call)) {}
  CallFuture(CallFuture &&) noexcept = default;
  CallFuture& operator=(CallFuture&& other) noexcept {
    if (this != &other) {
      Drop();
      call_ = std::move(other.call_);
    }
    return *this;
  }
  ~CallFuture() { Drop(); }

  /// Waits until there is a reply or a failure; the call's time-out bounds it. May be called anywhere, also inside a
  /// callback: there the waiting thread meanwhile runs requests to services of its own session that no worker has
  /// begun, so that it does not wait for itself. Where even that could not help, it gives kWouldDeadlock at once.
  CallResult<Reply> Wait() const { return CallResult<Reply>(call_->Wait()); }
  /// The result if it is there.
  [[nodiscard]] std::optional<CallResult<Reply>> Poll() const {
    return call_->done() ? std::optional(Wait()) : std::nullopt;
  }
  [[nodiscard]] bool done() const noexcept { return call_->done(); }
  /// Ends the call as kCancelled unless it has ended. A request that the server has not begun is not handled.
  void Cancel() const noexcept { call_->Cancel(); }

 private:
  void Drop() noexcept {
    if (call_) call_->Cancel();
  }

  std::shared_ptr<PendingCall> call_;
};

/// Names a call that was made with a callback, to cancel it. Copying shares; dropping it does nothing. Thread-safe.
class CallTicket {
 public:
  CallTicket() = default;
  explicit CallTicket(std::shared_ptr<PendingCall> call) : call_(std::move(call)) {}
  [[nodiscard]] bool done() const noexcept { return !call_ || call_->done(); }
  /// As CallFuture::Cancel; the callback is called with kCancelled.
  void Cancel() const noexcept {
    if (call_) call_->Cancel();
  }

 private:
  std::shared_ptr<PendingCall> call_;
};

}  // namespace hgros
