#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/session/carrier_set.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

inline constexpr std::size_t kCarrierKinds = 2;

/// By channel, what may carry it; a channel that is not named may take any.
using CarrierRules = std::map<std::string, CarrierSet, std::less<>>;

/// Which sessions are reached by which carriers, and from which one each is received: the cheapest that reached it
/// first. A session that is known to share memory with us soon is left to that, until it turns out that it cannot.
/// A channel that may take one carrier only, because one of the two sessions says so, is received from that one,
/// whatever carries the others.
///
/// Thread safety: all functions. Invariants: what is told to the listener of one peer is told in the order in which it
/// happened, one call at a time.
class PeerCarriers {
 public:
  /// `looks`: sessions of this host are looked for. `host`: this host's name.
  PeerCarriers(TransportListener& listener, Log& log, CarrierRules rules, bool looks, std::string host)
      : listener_(listener), log_(log), rules_(std::move(rules)), looks_(looks), host_(std::move(host)) {}

  /// Whether that session's messages on the channel are to be received over this carrier. The first who asks for a
  /// channel of no rule has all of those until Gone().
  [[nodiscard]] bool Take(SessionId peer, std::string_view channel, CarrierKind kind);

  /// The session was found on this host, and is to be reached through its shared memory if `shares`; or it has ended.
  void Found(SessionId peer, bool shares, CarrierRules rules);
  void Lost(SessionId peer);
  /// What it allows has changed; true if that makes a difference.
  [[nodiscard]] bool SetRules(SessionId peer, CarrierRules rules);

  /// How a session is reached when shared memory has not come in time.
  enum class Without { kNotNeeded, kReached, kUnreached };
  /// It is no longer left to shared memory, if that does not reach it.
  [[nodiscard]] Without GiveUp(SessionId peer);

  /// True if the session was received from over ZeroMQ and is reached through shared memory now: its channels, but for
  /// those with rules, are to move there one by one, and may be taken by both until then.
  [[nodiscard]] bool Came(PeerInfo peer, CarrierKind kind);
  /// The channel has moved.
  void Moved(SessionId peer, std::string_view channel);
  /// All have, whether that was told or not; false if none of them was to.
  [[nodiscard]] bool FinishMove(SessionId peer);
  /// True if its messages may now be received over another carrier.
  [[nodiscard]] bool Gone(const PeerInfo& peer, CarrierKind kind, std::string_view reason);

  [[nodiscard]] std::vector<PeerInfo> List() const;
  /// What the channel may take between here and there.
  [[nodiscard]] CarrierSet Allowed(SessionId peer, std::string_view channel) const;
  [[nodiscard]] bool IsReached(SessionId peer, CarrierKind kind) const;
  /// On this host, and not lost.
  [[nodiscard]] bool IsFound(SessionId peer) const;

 private:
  struct Peer {
    std::array<std::optional<PeerInfo>, kCarrierKinds> reached;
    std::optional<CarrierKind> taken;
    bool found = false;     // On this host.
    bool expected = false;  // Left to shared memory.
    bool moving = false;    // From ZeroMQ to shared memory.
    std::set<std::string, std::less<>> moved;
    CarrierRules rules;  // Its own.
  };
  // Under mutex_.
  [[nodiscard]] static bool IsReached(const Peer& peer);
  [[nodiscard]] CarrierSet Allowed(const Peer& peer, std::string_view channel) const;
  [[nodiscard]] std::string Why(const Peer& peer, const PeerInfo& info, CarrierKind kind) const;
  void Forget(SessionId id);

  TransportListener& listener_;
  Log& log_;
  const CarrierRules rules_;  // Ours.
  const bool looks_;
  const std::string host_;
  std::mutex telling_;  // Taken before mutex_.
  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Peer> peers_;
};

/// "shared memory".
[[nodiscard]] std::string_view NameOf(CarrierKind kind) noexcept;
/// "Session ID (PROCESS, process NUMBER on HOST)".
[[nodiscard]] std::string NameOf(const PeerInfo& peer);

}  // namespace hgros
