#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "hgros/base/ids.hpp"
#include "hgros/clock/clock_offset.hpp"

namespace hgros {

// The wall clock of this host, and how far the wall clocks of other sessions' hosts are ahead of it.
//
// Thread safety: all functions.
class HostClocks {
 public:
  // `wall`: empty for the system's clock.
  explicit HostClocks(std::function<Time()> wall = {}) : wall_(std::move(wall)) {}

  [[nodiscard]] Time Now() const { return wall_ ? wall_() : WallNow(); }

  void Add(SessionId peer, const ClockExchange& exchange);
  void Forget(SessionId peer);

  [[nodiscard]] std::optional<ClockOffset> OffsetTo(SessionId peer) const;
  // Time since the peer's wall clock showed `then`, as far as its offset is known. For statistics: cheap.
  [[nodiscard]] Duration Since(std::int64_t then_ns, SessionId peer) const;

 private:
  struct Peer {
    ClockOffsetEstimator estimator;
    ClockOffset latest;
    Time at;
  };
  const std::function<Time()> wall_;
  mutable std::mutex mutex_;
  std::unordered_map<SessionId, Peer> peers_;
  std::atomic<bool> empty_{true};
};

}  // namespace hgros
