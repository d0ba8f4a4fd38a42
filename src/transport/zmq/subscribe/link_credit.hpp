#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "transport/credit_window.hpp"
#include "transport/waker.hpp"

namespace hgros::zmq {

/// The credit of one link over ZeroMQ. The publisher gets it in Credit messages, which only the thread that waits for
/// input sends.
///
/// That thread is woken when a quarter of the window was consumed since the last Credit, or when the publisher has
/// used up all credit that it knows. Smaller amounts are sent with the next heartbeat.
///
/// Thread safety: tokens may end anywhere; the rest is called under the endpoint's mutex.
class LinkCredit : public TokenWindow<LinkCredit> {
 public:
  LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::shared_ptr<Waker> waker)
      : TokenWindow(window_messages, window_bytes), waker_(std::move(waker)) {}

  /// Answers a wake-up: returns whether the publisher waits for credit, or soon will.
  [[nodiscard]] bool AnswerWake() noexcept {
    woken_.store(false);
    return IsDue();
  }
  /// If the publisher does not know the consumed totals yet, sets `totals` to them and counts them as sent.
  [[nodiscard]] bool CollectNews(Totals& totals) noexcept;
  /// After a cut: the totals will be sent again, even if they were sent before.
  void ForgetTold() noexcept { untold_ = true; }

 private:
  friend class TokenWindow<LinkCredit>;
  void OnConsumed(std::uint64_t bytes) noexcept;
  [[nodiscard]] bool IsDue() const noexcept;

  std::atomic<bool> woken_{false};  // A wake-up was sent; further ones are omitted until it is answered.
  std::atomic<bool> untold_{false};
  const std::shared_ptr<Waker> waker_;
};

}  // namespace hgros::zmq
