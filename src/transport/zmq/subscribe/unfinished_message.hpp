#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// Finds out whether a publisher sends a message without an end. ZeroMQ keeps the frames of a message until the last
/// one has come, 64 bytes for each, and reports nothing (docs/decisions/0030).
///
/// After the first bytes that follow a silence, Look() is due every kLookEvery, until a message has been delivered or
/// there is silence again. A message of many bytes is legal. Memory that grows much faster than the bytes come, or
/// memory that runs out, is not.
///
/// Thread safety: none; it belongs to the leading thread.
class UnfinishedMessage {
 public:
  static constexpr auto kLookEvery = std::chrono::milliseconds(20);
  /// Less is not looked at. It can take 32 times as much memory.
  static constexpr std::uint64_t kSmallBytes = 1ULL << 20;
  /// So much memory per byte is too much, ...
  static constexpr std::uint64_t kMostPerByte = 8;
  /// ... if it is more than this, too, or than an eighth of the free memory.
  static constexpr std::uint64_t kMostBesides = 256ULL << 20;
  /// The program may have taken some for something else.
  static constexpr int kLooks = 3;

  /// `most_bytes`: the longest message.
  explicit UnfinishedMessage(std::uint64_t most_bytes) noexcept : most_bytes_(most_bytes) {}

  /// The connection that is watched from now on; negative: none. Others than tcp are not watched.
  void Watch(int connection) noexcept;
  [[nodiscard]] int connection() const noexcept { return connection_; }
  /// Bytes have come after a silence.
  void NoteBytes(SteadyTime now) noexcept;
  /// ZeroMQ has delivered a whole message.
  void NoteMessage() noexcept { delivered_ = true; }
  /// Whether more bytes than pings have come since the last call: the publisher is alive.
  [[nodiscard]] bool HasReceived() noexcept;

  /// When Look() is due; none while there is silence.
  [[nodiscard]] std::optional<SteadyTime> NextLook() const noexcept { return next_look_; }
  /// `all_read`: ZeroMQ has nothing left to be received. Returns what is wrong with the message, if anything is,
  /// and how to fix it; it completes "The message ...".
  [[nodiscard]] std::optional<std::string> Look(SteadyTime now, bool all_read);

 private:
  UnfinishedMessage(std::uint64_t most_bytes, int connection) noexcept
      : most_bytes_(most_bytes), connection_(connection) {}
  void Settle(std::uint64_t read) noexcept;

  std::uint64_t most_bytes_;
  int connection_ = -1;
  bool delivered_ = false;  // Since the last look.
  std::optional<SteadyTime> next_look_;
  std::uint64_t settled_ = 0;  // Bytes that ZeroMQ had read when it delivered the last message.
  std::uint64_t seen_ = 0;     // At the last look.
  std::uint64_t known_ = 0;    // At the last HasReceived().
  // When the message had become large: this process's memory, what was free, and the bytes.
  std::uint64_t resident_before_ = 0;
  std::uint64_t free_before_ = 0;
  std::uint64_t read_before_ = 0;
  int suspicious_looks_ = 0;
};

}  // namespace hgros::zmq
