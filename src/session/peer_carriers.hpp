#pragma once

#include <array>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// The carriers, the cheapest first.
enum class CarrierKind { kShm, kZmq };
inline constexpr std::size_t kCarrierKinds = 2;

/// Which sessions are reached by which carriers, and from which one each is received: the cheapest that reached it
/// first. A session that is known to share memory with us soon is left to that, until it turns out that it cannot.
///
/// Thread safety: all functions. Invariants: what is told to the listener of one peer is told in the order in which it
/// happened, one call at a time.
class PeerCarriers {
 public:
  PeerCarriers(TransportListener& listener, Log& log) : listener_(listener), log_(log) {}

  /// Whether messages of that session are to be received over this carrier. The first who asks has it until Gone().
  [[nodiscard]] bool Take(SessionId peer, CarrierKind kind);

  /// The session was found on this host, and is to be reached through its shared memory; or that has failed, or ended.
  void Expect(SessionId peer);
  void Unexpect(SessionId peer);

  /// How a session is reached when shared memory has not come in time.
  enum class Without { kNotNeeded, kReached, kUnreached };
  /// It is no longer left to shared memory, if that does not reach it.
  [[nodiscard]] Without GiveUp(SessionId peer);

  void Came(PeerInfo peer, CarrierKind kind);
  /// True if its messages may now be received over another carrier.
  [[nodiscard]] bool Gone(const PeerInfo& peer, CarrierKind kind, std::string_view reason);

  [[nodiscard]] std::vector<PeerInfo> List() const;

 private:
  struct Peer {
    std::array<std::optional<PeerInfo>, kCarrierKinds> reached;
    std::optional<CarrierKind> taken;
    bool expected = false;
  };
  [[nodiscard]] static bool IsReached(const Peer& peer);
  void Forget(SessionId id);

  TransportListener& listener_;
  Log& log_;
  std::mutex telling_;  // Taken before mutex_.
  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Peer> peers_;
};

}  // namespace hgros
