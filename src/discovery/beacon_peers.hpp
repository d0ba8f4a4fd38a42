#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "discovery/datagram.hpp"
#include "discovery/peer_book.hpp"

namespace hgros::discovery {

/// What is made of the datagrams: who is there, where, and who fell silent. It trusts nobody far: a session is where it
/// was heard first, until that place falls silent or says goodbye; there are at most kMaxPeers.
///
/// Not thread-safe, but for the book.
class BeaconPeers {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxPeers = 1024;

  BeaconPeers(PeerBook& book, std::chrono::milliseconds patience) : book_(book), patience_(patience) {}

  enum class Verdict {
    kNew,
    kKnown,
    kIgnored,  ///< From another place, of an earlier life, or a stranger's goodbye.
    kTooMany,
  };
  Verdict Hear(const Heard& heard, const std::string& sender, Clock::time_point now);
  /// Strikes out who was not heard for too long.
  void Expire(Clock::time_point now);
  /// When the next one will have been silent for too long.
  [[nodiscard]] std::optional<Clock::time_point> next_expiry() const;

 private:
  struct Peer {
    std::string sender;
    std::uint64_t incarnation;
    Clock::time_point last_heard;
  };

  PeerBook& book_;
  const std::chrono::milliseconds patience_;
  std::unordered_map<SessionId, Peer> peers_;
};

}  // namespace hgros::discovery
