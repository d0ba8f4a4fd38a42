#pragma once

#include <algorithm>
#include <chrono>
#include <map>

#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/peer_info.hpp"

namespace hgros::zmq {

/// Logs which peers have been silent for two heartbeats, and that they are heard again. A silent peer is not gone: that
/// takes the peer timeout, because messages of a lossless channel are lost then.
///
/// Thread safety: none; for the leading thread.
class SilenceLog {
 public:
  using Time = std::chrono::steady_clock::time_point;

  SilenceLog(Log& log, std::chrono::milliseconds heartbeat)
      : log_(log), patience_(std::max(2 * heartbeat, kLeastPatience)) {}

  /// In each tick, for each connected peer: when something came from it last. It may be connected in both directions.
  void Note(const PeerInfo& peer, Time heard);
  /// At the end of a tick. Returns when the next peer will have been silent for too long, at the earliest.
  Time Report(Time now);

 private:
  static constexpr std::chrono::milliseconds kLeastPatience{200};  // Two short heartbeats may be late.

  struct Heard {
    PeerInfo peer;
    Time at{};
    bool silent = false;     // This was logged.
    bool connected = false;  // Since the last report.
  };

  Log& log_;
  const std::chrono::milliseconds patience_;
  std::map<SessionId, Heard> peers_;
};

}  // namespace hgros::zmq
