#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "transport/waker.hpp"

namespace hgros::zmq {

/// The receiving side's account of one link: what came, what was consumed, what the publisher was told.
///
/// Every message holds a token made by Take(); its end, on any thread, counts the message as consumed. The thread
/// that waits for input is woken when a quarter of the window was consumed since the publisher was last told, or when
/// the publisher has used up all it knows of; what stays below that is told with the next heartbeat.
///
/// Thread safety: tokens may end anywhere; the rest is called under the endpoint's mutex.
class LinkCredit : public std::enable_shared_from_this<LinkCredit> {
 public:
  LinkCredit(std::uint64_t window_messages, std::uint64_t window_bytes, std::shared_ptr<Waker> waker);

  /// Counts a message as received.
  [[nodiscard]] std::shared_ptr<const void> Take(std::uint64_t bytes);
  /// Counts a message as received and consumed: one that was dropped.
  void Skip(std::uint64_t bytes) noexcept;

  struct Totals {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
  };
  [[nodiscard]] Totals received() const noexcept { return {received_messages_.load(), received_bytes_.load()}; }
  /// Received and not consumed.
  [[nodiscard]] Totals in_flight() const noexcept {
    // What was consumed first: it may grow meanwhile.
    const Totals consumed{consumed_messages_.load(), consumed_bytes_.load()};
    return {received_messages_.load() - consumed.messages, received_bytes_.load() - consumed.bytes};
  }
  /// The publisher waits for news, or soon will: a quarter of the window was consumed, or it has used up its credit.
  /// For the thread that waits for input: answers a wake-up.
  [[nodiscard]] bool TakeDue() noexcept {
    woken_.store(false);
    return Due();
  }
  /// All consumed so far, if the publisher does not know yet; afterwards it counts as told.
  [[nodiscard]] bool TellIfNews(Totals& consumed) noexcept;
  void SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept;
  /// Whether a publisher that keeps to the window may send one more message.
  [[nodiscard]] bool HasRoom() const noexcept;
  /// Likewise, for one that may not have heard yet that its window has shrunk.
  [[nodiscard]] bool HadRoom() const noexcept;
  /// The publisher is to be told again, whatever it was told before: after a cut.
  void Retell() noexcept { untold_ = true; }

 private:
  struct Token;
  void Consume(std::uint64_t bytes) noexcept;
  [[nodiscard]] bool Due() const noexcept;
  [[nodiscard]] bool Within(std::uint64_t messages, std::uint64_t bytes) const noexcept;

  std::atomic<std::uint64_t> window_messages_;
  std::atomic<std::uint64_t> window_bytes_;
  std::uint64_t widest_messages_;  // Of all windows so far; the endpoint's mutex guards both.
  std::uint64_t widest_bytes_;
  std::atomic<std::uint64_t> received_messages_{0};
  std::atomic<std::uint64_t> received_bytes_{0};
  std::atomic<std::uint64_t> consumed_messages_{0};
  std::atomic<std::uint64_t> consumed_bytes_{0};
  std::atomic<std::uint64_t> told_messages_{0};
  std::atomic<std::uint64_t> told_bytes_{0};
  std::atomic<bool> woken_{false};  // A wake-up is on its way; further ones are spared until it was answered.
  std::atomic<bool> untold_{false};
  const std::shared_ptr<Waker> waker_;
};

}  // namespace hgros::zmq
