#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "discovery/beacon/datagram.hpp"
#include "discovery/peer_book.hpp"

namespace hgros::discovery {

/// The peers known from datagrams: their addresses and when they fell silent. Limits the effect of forged datagrams:
/// a session keeps the address at which it was first heard until it expires or says goodbye, and there are at most
/// kMaxPeers. If there are more, those of the address with the most peers make room for those of others.
///
/// Not thread-safe; only the book is.
class BeaconPeers {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxPeers = 1024;

  BeaconPeers(PeerBook& book, std::chrono::milliseconds patience) : book_(book), patience_(patience) {}

  enum class Verdict {
    kNew,
    kKnown,
    kIgnored,  ///< From another address or an earlier incarnation, or a goodbye of an unknown peer.
    kTooMany,
  };
  Verdict Hear(const Heard& heard, const std::string& sender, Clock::time_point now);
  /// Removes peers that were silent for too long.
  void Expire(Clock::time_point now);
  /// When the next peer will have been silent for too long.
  [[nodiscard]] std::optional<Clock::time_point> next_expiry() const;

 private:
  struct Peer {
    std::string sender;
    std::uint64_t incarnation;
    Clock::time_point last_heard;
  };

  using Peers = std::unordered_map<SessionId, Peer>;
  Peers::iterator Remove(Peers::iterator entry, std::string_view reason);
  [[nodiscard]] bool MakeRoomFor(const std::string& sender);

  PeerBook& book_;
  const std::chrono::milliseconds patience_;
  Peers peers_;
  std::unordered_map<std::string, std::unordered_set<SessionId>> by_sender_;
};

}  // namespace hgros::discovery
