#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

namespace hgros {

/// The receiving side's account of one link: the counts of received and consumed messages and bytes, and the window,
/// which limits what may be in flight. A transport's own class derives from TokenWindow and reports the consumed
/// counts to the publisher.
///
/// Thread safety: the counts may be read anywhere. SetWindow() and the questions about room belong to the thread that
/// reads the link, or are called under a mutex.
class CreditWindow {
 public:
  struct Totals {
    std::uint64_t messages = 0;
    std::uint64_t bytes = 0;
  };

  CreditWindow(const CreditWindow&) = delete;
  CreditWindow& operator=(const CreditWindow&) = delete;

  /// The number of messages received.
  [[nodiscard]] std::uint64_t received() const noexcept { return received_messages_.load(); }
  [[nodiscard]] std::uint64_t received_bytes() const noexcept { return received_bytes_.load(); }
  /// Messages and bytes received and not consumed.
  [[nodiscard]] Totals in_flight() const noexcept;
  /// Whether the window allows one more message.
  [[nodiscard]] bool HasRoomNow() const noexcept;
  /// Whether a publisher may send one more message if it does not know yet that its window has shrunk.
  [[nodiscard]] bool HasRoom() const noexcept { return IsInFlightBelow(widest_messages_, widest_bytes_); }
  void SetWindow(std::uint64_t messages, std::uint64_t bytes) noexcept;
  /// A wider window was asked for: the publisher may use it before its answer is known here.
  void Widen(std::uint64_t messages, std::uint64_t bytes) noexcept;

 protected:
  CreditWindow(std::uint64_t messages, std::uint64_t bytes) noexcept
      : window_messages_(messages), window_bytes_(bytes), widest_messages_(messages), widest_bytes_(bytes) {}
  ~CreditWindow() = default;

  void CountReceived(std::uint64_t bytes) noexcept {
    received_messages_.fetch_add(1);
    received_bytes_.fetch_add(bytes);
  }
  void CountConsumed(std::uint64_t bytes) noexcept {
    // Bytes first: a thread that sees the message counted sees its bytes as well.
    consumed_bytes_.fetch_add(bytes);
    consumed_messages_.fetch_add(1);
  }
  [[nodiscard]] Totals window() const noexcept {
    return {window_messages_.load(std::memory_order_relaxed), window_bytes_.load(std::memory_order_relaxed)};
  }
  /// The messages consumed, then their bytes.
  [[nodiscard]] Totals consumed() const noexcept {
    const std::uint64_t messages = consumed_messages_.load();
    return {messages, consumed_bytes_.load()};
  }
  /// The totals that the publisher has last received.
  [[nodiscard]] Totals told() const noexcept {
    const std::uint64_t messages = told_messages_.load();
    return {messages, told_bytes_.load()};
  }
  void SetTold(const Totals& totals) noexcept {
    told_messages_.store(totals.messages);
    told_bytes_.store(totals.bytes);
  }
  /// Whether `news` is a quarter of the window or more, so that the publisher must get it.
  [[nodiscard]] bool IsQuarter(const Totals& news) const noexcept {
    const Totals whole = window();
    return news.messages * 4 >= whole.messages || news.bytes * 4 >= whole.bytes;
  }

 private:
  [[nodiscard]] bool IsInFlightBelow(std::uint64_t messages, std::uint64_t bytes) const noexcept;

  std::atomic<std::uint64_t> window_messages_;
  std::atomic<std::uint64_t> window_bytes_;
  std::uint64_t widest_messages_;  // The widest window so far.
  std::uint64_t widest_bytes_;
  std::atomic<std::uint64_t> received_messages_{0};
  std::atomic<std::uint64_t> received_bytes_{0};
  std::atomic<std::uint64_t> consumed_messages_{0};
  std::atomic<std::uint64_t> consumed_bytes_{0};
  std::atomic<std::uint64_t> told_messages_{0};
  std::atomic<std::uint64_t> told_bytes_{0};
};

/// One message in flight holds one token.
template <typename Link>
class CreditToken {
 public:
  CreditToken(std::shared_ptr<Link> link, std::uint64_t bytes) noexcept : link_(std::move(link)), bytes_(bytes) {}
  ~CreditToken() { link_->Consume(bytes_); }
  CreditToken(const CreditToken&) = delete;
  CreditToken& operator=(const CreditToken&) = delete;

 private:
  const std::shared_ptr<Link> link_;
  const std::uint64_t bytes_;
};

/// A credit window whose messages hold tokens. The end of a token, on any thread, counts its message as consumed and
/// calls `void Link::OnConsumed(std::uint64_t bytes) noexcept`, which may be private if TokenWindow is a friend.
/// `Link` is the class that derives from this; the call is direct, not virtual.
template <typename Link>
class TokenWindow : public CreditWindow, public std::enable_shared_from_this<Link> {
 public:
  /// Counts a message as received.
  [[nodiscard]] std::shared_ptr<const void> AdmitMessage(std::uint64_t bytes) {
    auto token = std::make_shared<const CreditToken<Link>>(this->shared_from_this(), bytes);
    CountReceived(bytes);
    return token;
  }
  /// Counts a message that was dropped as received and consumed.
  void SkipMessage(std::uint64_t bytes) noexcept {
    CountReceived(bytes);
    Consume(bytes);
  }

 protected:
  using CreditWindow::CreditWindow;
  ~TokenWindow() = default;

 private:
  friend class CreditToken<Link>;
  void Consume(std::uint64_t bytes) noexcept {
    CountConsumed(bytes);
    static_cast<Link*>(this)->OnConsumed(bytes);
  }
};

}  // namespace hgros
