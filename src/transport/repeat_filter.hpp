#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>

#include "hgros/base/ids.hpp"

namespace hgros {

/// Recognizes messages that came before, by sender, publisher, incarnation and sequence. Messages of one sender never
/// make another sender's messages count as repeats.
///
/// Threads that publish through one handle may send in another order than they number. So the last kWindow sequences
/// are remembered one by one; an older one counts as a repeat.
/// Thread safety: none; the owner guards it.
class RepeatFilter {
 public:
  static constexpr std::uint64_t kWindow = 256;

  /// True if the message is new, and remembers it. Messages without a publisher or sequence are always new.
  [[nodiscard]] bool Pass(SessionId from, const MessageId& id);

 private:
  struct Seen {
    std::uint64_t incarnation = 0;
    std::uint64_t highest = 0;
    std::array<std::uint64_t, kWindow / 64> bits{};  // Bit s % kWindow belongs to sequence s.
  };
  std::map<std::pair<std::uint64_t, std::uint64_t>, Seen> publishers_;  // By ids of sender and publisher.
};

}  // namespace hgros
