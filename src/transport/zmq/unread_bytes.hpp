#pragma once

#include <cstddef>
#include <cstdint>

namespace hgros::zmq {

/// Finds out whether the other side of a tcp connection leaves messages unread that nothing else limits: ZeroMQ keeps
/// them without a limit, and reports nothing. What the other side's kernel has acknowledged is compared with what was
/// sent. Other bytes on the connection make the result smaller: the other side must read them, too.
///
/// Thread safety: none.
class UnreadBytes {
 public:
  /// Enough for the answers to a subscriber of all channels, with their schemas.
  static constexpr std::size_t kMost = 64ULL << 20;

  /// The connection from now on; negative: none. Others than tcp are not watched.
  void Watch(int connection);
  [[nodiscard]] int connection() const noexcept { return connection_; }
  /// Counts a message. True, once for each connection, if too much waits: more than kMost, or than a sixteenth of the
  /// free memory.
  [[nodiscard]] bool Add(std::size_t bytes);

 private:
  int connection_ = -1;
  std::size_t most_ = 0;       // 0: not known yet.
  std::uint64_t sent_ = 0;     // Since `acked_`.
  std::uint64_t checked_ = 0;  // `sent_` at the last check.
  std::uint64_t acked_ = 0;    // When nothing may have waited.
};

}  // namespace hgros::zmq
