#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bridge/joined/transport_move.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// Decides over which transport each peer is received: the cheapest one that reaches it. A peer is left to the
/// transports of this host that it announces, until it is clear that they cannot reach it. If a cheaper transport
/// reaches it later, its channels move there. Channels that may use the same transports are decided on together; a
/// rule of either side restricts which a channel may use.
///
/// Thread safety: all functions. Invariants: events of one peer are reported to the listener in the order in which
/// they happened, one call at a time. All channels of a peer that move, move at the same time.
class PeerTransports {
 public:
  /// `transports` outlives it. `looks`: true if sessions of this host are searched. `self`: this session.
  PeerTransports(const TransportList& transports, TransportListener& listener, Log& log, TransportRules rules,
                 bool looks, PeerInfo self)
      : transports_(transports),
        listener_(listener),
        log_(log),
        rules_(std::move(rules)),
        looks_(looks),
        self_(std::move(self)) {}

  /// Whether that session's messages on the channel must be received over this transport. The first transport that
  /// asks gets the channel, and all that may use the same transports, unless a cheaper one reaches the session or is
  /// expected to.
  [[nodiscard]] bool Claim(SessionId peer, std::string_view channel, TransportIndex transport);

  /// The session was found on this host, and is left to these transports for now.
  void Found(SessionId peer, TransportSet expected, TransportRules rules);
  /// This session and that one exchange messages: from now on it is expected over these transports. False if this is
  /// known already, or the session is not found.
  [[nodiscard]] bool MakePartner(SessionId peer, TransportSet expected);
  /// Found sessions that exchange nothing with this one are no longer left to transports of the host. True if other
  /// transports may now be used for one of them.
  [[nodiscard]] bool GiveUpStrangers();
  /// It has ended, or is no longer found.
  void Lost(SessionId peer);
  /// Its rules have changed; true if this changes anything.
  [[nodiscard]] bool SetRules(SessionId peer, TransportRules rules);

  /// A session that the expected transports have not reached.
  struct GivenUp {
    TransportSet missing;
    bool matters = false;  ///< No transport of this host reaches it, and nothing is received from it yet.
    std::optional<TransportIndex> reached_by;  ///< The transport that is used instead.
  };
  /// The session is no longer left to transports that do not reach it.
  [[nodiscard]] GivenUp GiveUp(SessionId peer);

  /// Identifies one move of a peer's channels.
  using MoveNumber = std::uint64_t;
  /// The transport reaches the peer. If it is cheaper than the one that the peer is received over, a move begins; call
  /// OpenMove() when everything is ready for it.
  [[nodiscard]] std::optional<MoveNumber> Came(PeerInfo peer, TransportIndex transport);
  /// From now on channels are received over both transports.
  void OpenMove(SessionId peer);
  /// The channel's move; empty if it does not move.
  [[nodiscard]] std::optional<MoveWay> MoveOf(SessionId peer, std::string_view channel) const;
  /// The sessions whose channels move.
  [[nodiscard]] std::vector<SessionId> Moving() const;
  /// The channel has moved: it is received over the new transport only.
  void Moved(SessionId peer, std::string_view channel);
  /// All channels have moved. False if that move has ended already.
  [[nodiscard]] bool FinishMove(SessionId peer, MoveNumber number);
  /// Begins a move if a cheaper transport reaches the peer and no channel of it moves any more.
  [[nodiscard]] std::optional<MoveNumber> NextMove(SessionId peer);
  /// The transport no longer reaches the peer. True if its messages may now be received over another one.
  [[nodiscard]] bool Gone(const PeerInfo& peer, TransportIndex transport, std::string_view reason);

  [[nodiscard]] std::vector<PeerInfo> List() const;
  /// The transports that the channel may use between this session and that one.
  [[nodiscard]] TransportSet Allowed(SessionId peer, std::string_view channel) const;
  /// The transports that reach the peer.
  [[nodiscard]] TransportSet ReachedBy(SessionId peer) const;
  /// On this host, and not lost.
  [[nodiscard]] bool IsFound(SessionId peer) const;
  /// For the log. Only its id if no transport reaches it.
  [[nodiscard]] std::string NameOf(SessionId peer) const;
  /// Found, and exchanging messages with this session.
  [[nodiscard]] bool IsPartner(SessionId peer) const;

 private:
  // The decision for all channels that may use the same transports.
  struct Choice {
    std::optional<TransportIndex> taken;
    std::optional<TransportIndex> from;  // They move from there to `taken`.
    std::set<std::string, std::less<>> moved;
  };
  struct Peer {
    std::map<TransportIndex, PeerInfo> reached;
    TransportSet expected;
    bool found = false;    // On this host.
    bool partner = false;  // It exchanges messages with this session.
    std::map<TransportSet, Choice> choices;
    std::optional<MoveNumber> move;  // Set until NextMove() after its end.
    bool move_is_open = false;
    TransportRules rules;  // Its own.
  };
  // Under mutex_.
  [[nodiscard]] static TransportSet ReachedBy(const Peer& peer);
  [[nodiscard]] static bool IsMoving(const Peer& peer);
  [[nodiscard]] const Peer* Find(SessionId id) const;
  [[nodiscard]] Peer* Find(SessionId id) { return const_cast<Peer*>(std::as_const(*this).Find(id)); }
  [[nodiscard]] TransportSet Allowed(const Peer& peer, std::string_view channel) const;
  // The transport that carries the peer's messages; the peer is reached.
  [[nodiscard]] TransportIndex Current(const Peer& peer) const;
  [[nodiscard]] std::string Why(const Peer& peer, const PeerInfo& info, TransportIndex transport) const;
  [[nodiscard]] std::optional<MoveNumber> StartMove(Peer& peer);
  void Forget(SessionId id);
  // "Session A reaches session B through ...": not under mutex_.
  void Say(const PeerInfo& peer, std::string_view what, const std::string& how);

  const TransportList& transports_;
  TransportListener& listener_;
  Log& log_;
  const TransportRules rules_;  // Ours.
  const bool looks_;
  const PeerInfo self_;
  std::mutex telling_;  // Taken before mutex_.
  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Peer> peers_;
  MoveNumber last_move_ = 0;
};

}  // namespace hgros
