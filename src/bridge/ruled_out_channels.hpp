#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "bridge/announcer.hpp"
#include "bridge/peer_transports.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/transport_list.hpp"

namespace hgros {

/// Reports, once each, the channels that this session and another one of its host share, and for which the rules of
/// both (`transports` of a channel) leave no transport.
///
/// Thread safety: all functions.
class RuledOutChannels {
 public:
  /// All outlive it. `later`: runs an errand after a delay.
  struct Means {
    const TransportList& transports;
    const PeerTransports& peers;
    const Announcer& announcer;
    std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)> later;
    Log& log;
  };
  /// `ruled`: whether this session has rules. Nothing is looked for as long as no session has any.
  RuledOutChannels(Means means, bool ruled) : means_(std::move(means)), ruled_(ruled) {}

  [[nodiscard]] TransportRules RulesOf(const Announcement& peer);
  /// Channels or rules have changed: looks for such channels when every transport has had time to reach the other
  /// sessions.
  void LookLater();

 private:
  void LookIn(std::chrono::nanoseconds delay);
  void Look();
  void Report(const ChannelAnnouncement& there, const Announcement& peer, TransportSet allowed) const;

  const Means means_;
  std::atomic<bool> ruled_;
  std::atomic<bool> looks_{false};  // An errand will look.
  std::atomic<std::chrono::steady_clock::time_point> changed_{};
  std::mutex said_mutex_;
  std::set<std::pair<std::string, std::uint64_t>> said_;  // Channels and sessions.
};

}  // namespace hgros
