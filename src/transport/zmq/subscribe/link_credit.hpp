#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "transport/credit_window.hpp"
#include "transport/waker.hpp"

namespace hgros::zmq {

/// The credit of one link over ZeroMQ: the publisher is told with Credit messages, which only the thread that waits for
/// input sends.
///
/// That thread is woken when a quarter of the window was consumed since the publisher was last told, or when the
/// publisher has used up all credit it knows of. What stays below that is told with the next heartbeat.
///
/// Thread safety: tokens may end anywhere; the rest is called under the endpoint's mutex.
class LinkCredit : public TokenWindow<LinkCredit> {
 public:
  LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::shared_ptr<Waker> waker)
      : TokenWindow(window_messages, window_bytes), waker_(std::move(waker)) {}

  /// Answers a wake-up: whether the publisher waits for news, or soon will.
  [[nodiscard]] bool AnswerWake() noexcept {
    woken_.store(false);
    return IsDue();
  }
  /// Sets `totals` to all that was consumed if the publisher does not know it yet; then counts it as told.
  [[nodiscard]] bool CollectNews(Totals& totals) noexcept;
  /// Tells the publisher again, whatever it was told before: after a cut.
  void ForgetTold() noexcept { untold_ = true; }

 private:
  friend class TokenWindow<LinkCredit>;
  void OnConsumed(std::uint64_t bytes) noexcept;
  [[nodiscard]] bool IsDue() const noexcept;

  std::atomic<bool> woken_{false};  // A wake-up is on its way; further ones are spared until it is answered.
  std::atomic<bool> untold_{false};
  const std::shared_ptr<Waker> waker_;
};

}  // namespace hgros::zmq
