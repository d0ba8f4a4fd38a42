#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "transport/credit_window.hpp"
#include "transport/zmq/subscribe/due_credits.hpp"

namespace hgros::zmq {

/// The credit of one link over ZeroMQ. The publisher gets it in Credit messages, which only the thread that waits for
/// input sends.
///
/// Credit is due when a quarter of the window was consumed since the last Credit, or when the publisher has used up
/// all credit that it knows and something was consumed. Smaller amounts are sent with the next heartbeat.
///
/// Thread safety: tokens may end anywhere; the rest is called under the endpoint's mutex.
class LinkCredit : public TokenWindow<LinkCredit> {
 public:
  /// Credit that is due is added to `due`; null if nobody is told of it.
  LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::string channel,
             std::shared_ptr<DueCredits> due);
  ~LinkCredit();
  LinkCredit(const LinkCredit&) = delete;
  LinkCredit& operator=(const LinkCredit&) = delete;

  [[nodiscard]] const std::string& channel() const noexcept { return channel_; }
  /// To be called after a message was received, which may have been the last one that the publisher has credit for.
  void OnReceived() noexcept { AddIfDue(false); }
  /// It was taken out of `due`. To be called before CollectNews(), so that what is consumed after that is added again.
  void OnTaken() noexcept { listed_.store(false); }
  /// If the publisher does not know the consumed totals yet, sets `totals` to them and counts them as sent.
  [[nodiscard]] bool CollectNews(Totals& totals) noexcept;
  /// After a cut: the totals will be sent again, even if they were sent before.
  void ForgetTold() noexcept;

 private:
  friend class TokenWindow<LinkCredit>;
  void OnConsumed(std::uint64_t bytes) noexcept;
  [[nodiscard]] bool IsDue() const noexcept;
  void AddIfDue(bool wake) noexcept;

  const std::string channel_;
  const std::shared_ptr<DueCredits> due_;
  std::atomic<bool> listed_{false};  // It is in due_.
  std::atomic<bool> untold_{false};
};

}  // namespace hgros::zmq
