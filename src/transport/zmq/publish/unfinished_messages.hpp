#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "transport/zmq/control.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// Finds tcp connections that send a message without an end. ZeroMQ keeps the frames of a message until the last one
/// has come, without a limit, and reports nothing (docs/decisions/0030).
///
/// The first bytes after a silence wake the owner's poller. From then on the bytes that ZeroMQ has read are compared
/// every kLookEvery with the messages that it has delivered, until the connection is silent or has delivered one. If
/// its last message is longer ago than kSettleEvery, it waits for bytes again as soon as it has delivered one, without
/// a look.
///
/// Thread safety: none; the endpoint's mutex guards it. The descriptor of fd() may be polled without it.
class UnfinishedMessages {
 public:
  /// Four times the longest message of a subscriber.
  static constexpr std::uint64_t kMostBytes = 4 * kMaxUpstreamBytes;
  /// Pings of ZeroMQ are no messages: encrypted, and one every 100 ms, they have 420 bytes per second.
  static constexpr std::uint64_t kPingBytesPerSecond = 1024;
  static constexpr auto kLookEvery = std::chrono::milliseconds(20);
  static constexpr auto kSettleEvery = std::chrono::milliseconds(100);

  /// Throws Error.
  UnfinishedMessages();
  ~UnfinishedMessages() { Close(); }
  UnfinishedMessages(const UnfinishedMessages&) = delete;
  UnfinishedMessages& operator=(const UnfinishedMessages&) = delete;

  void Add(int connection, SteadyTime now);
  void Remove(int connection);
  void Clear();
  /// Closes its descriptors.
  void Close() noexcept;
  /// ZeroMQ has delivered a whole message of this connection.
  void NoteMessage(int connection);

  [[nodiscard]] int fd() const noexcept { return epoll_; }
  /// To be set when the descriptor has become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  /// To be called when all delivered messages have been read.
  void SettleDelivered(SteadyTime now);
  /// Whether Look() is to be called as soon as all delivered messages have been read.
  [[nodiscard]] bool IsLookDue();
  /// The connections whose message has become too long.
  [[nodiscard]] std::vector<int> Look(SteadyTime now);

 private:
  struct Connection {
    std::uint64_t settled = 0;  // Bytes that ZeroMQ had read when it delivered the last message,
    SteadyTime settled_at{};    // and when that was noticed.
    std::uint64_t seen = 0;     // Bytes that it had read at the last look.
    bool moving = false;        // It is looked at.
    bool delivered = false;     // Since the last look.
  };
  void WaitForBytes(int connection);
  void Settle(int fd, Connection& connection, SteadyTime now);
  void SetTimer();
  void StopTimer();

  int epoll_;
  int timer_;
  std::atomic<bool> input_{true};
  bool timer_runs_ = false;
  bool due_ = false;
  std::unordered_map<int, Connection> connections_;
  std::size_t moving_ = 0;      // How many of them are.
  std::vector<int> delivered_;  // Those that may be settled before the next look.
};

}  // namespace hgros::zmq
