#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/services/call_result.hpp"

namespace hgros {

/// A call that is under way, without its type. CallFuture and CallTicket hold one. Thread-safe.
class HGROS_EXPORT PendingCall {
 public:
  virtual ~PendingCall() = default;
  /// Blocks until the call has ended.
  virtual const CallEnd& Wait() = 0;
  [[nodiscard]] virtual bool done() const noexcept = 0;
  virtual void Cancel() noexcept = 0;
};

/// A reply that may still come. Move-only. Dropping it cancels the call, because nobody could see the reply.
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

  /// Waits until there is a reply or a failure, at most until the call's timeout. May be called anywhere. Inside a
  /// callback, the waiting thread meanwhile runs requests to services of its own session that no worker has begun, so
  /// that it does not wait for itself. If that cannot help either, it returns kWouldDeadlock at once.
  CallResult<Reply> Wait() const { return CallResult<Reply>(call_->Wait()); }
  /// The result, if there is one already.
  [[nodiscard]] std::optional<CallResult<Reply>> Poll() const {
    return call_->done() ? std::optional(Wait()) : std::nullopt;
  }
  [[nodiscard]] bool done() const noexcept { return call_->done(); }
  /// Ends the call with kCancelled, unless it has ended. The server does not handle the request if it has not begun it.
  void Cancel() const noexcept { call_->Cancel(); }

 private:
  void Drop() noexcept {
    if (call_) call_->Cancel();
  }

  std::shared_ptr<PendingCall> call_;
};

/// Cancels a call that was made with a callback. Copies refer to the same call; dropping it does nothing. Thread-safe.
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
