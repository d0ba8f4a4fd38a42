#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "discovery/beacon/datagram.hpp"
#include "discovery/peer_book.hpp"

namespace hgros::discovery {

/// The peers known from datagrams: their addresses and when they fell silent. Limits the effect of forged datagrams:
/// - A session is at each address from which it is heard, at most kMaxPlaces, until it expires there or says goodbye
///   there. The first one describes it, and all tell endpoints. So a wrong address where nobody answers hides no
///   session.
/// - There are at most kMaxPeers. If there are more, those of the address with the most peers make room for those of
///   others.
///
/// Not thread-safe; only the book is.
class BeaconPeers {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxPeers = 1024;
  static constexpr std::size_t kMaxPlaces = 16;  // If more come, each of them has its turn.

  BeaconPeers(PeerBook& book, std::chrono::milliseconds patience) : book_(book), patience_(patience) {}

  enum class Verdict {
    kNew,  ///< Or at an address at which it was not heard before.
    kKnown,
    kIgnored,  ///< From an earlier incarnation, or a goodbye of an unknown peer.
    kTooMany,
  };
  Verdict Hear(const Heard& heard, const std::string& sender, Clock::time_point now);
  /// Removes peers that were silent for too long.
  void Expire(Clock::time_point now);
  /// When the next peer will have been silent for too long.
  [[nodiscard]] std::optional<Clock::time_point> next_expiry() const;

 private:
  struct Place {
    std::string sender;
    Announcement peer;  // As heard from there.
    Clock::time_point last_heard;
  };
  using Places = std::vector<Place>;  // Never empty, in the order in which they were heard first.
  using Peers = std::unordered_map<SessionId, Places>;

  [[nodiscard]] static Announcement Merged(const Places& places);
  void ForgetSender(const std::string& sender, SessionId session);
  void RemoveFirstPlace(Peers::value_type& entry);
  // Removes the places that the predicate holds for, and the peer if none is left. Returns the next peer.
  template <class Ended>
  Peers::iterator RemoveIf(Peers::iterator entry, const Ended& ended, std::string_view reason);
  [[nodiscard]] bool MakeRoomFor(const std::string& sender);

  PeerBook& book_;
  const std::chrono::milliseconds patience_;
  Peers peers_;
  std::unordered_map<std::string, std::unordered_set<SessionId>> by_sender_;  // Of first places.
};

}  // namespace hgros::discovery
