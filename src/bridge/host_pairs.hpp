#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "bridge/announcer.hpp"
#include "bridge/open_transports.hpp"
#include "bridge/peer_transports.hpp"
#include "bridge/stranger_channels.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/network_bridge.hpp"

namespace hgros {

/// Connects this session, over the transports of its host, with the sessions of the host that it exchanges messages
/// with: one of the two publishes what the other one subscribes to. This follows from both announcements, so it is
/// decided whenever one of them changes. A pair lasts until one of its sessions ends, even if they exchange nothing any
/// more: otherwise an observer would connect again for each look.
///
/// Thread safety: all functions.
class HostPairs {
 public:
  /// A living session of this host is left to the transports of this host alone for this long.
  static constexpr auto kHostPatience = std::chrono::seconds(2);

  /// All outlive it. `ask_again`: transports ask again which channels they receive.
  struct Means {
    const BridgeOptions& options;
    const TransportList& transports;
    const OpenTransports& open;
    PeerTransports& peers;
    const Announcer& announcer;
    Log& log;
    std::function<void()> ask_again;
  };
  explicit HostPairs(Means means);

  /// A session was found on this host, and neither side's list excludes it.
  void Found(const Announcement& peer, TransportRules rules);
  /// It announces something else than before.
  void Changed(const Announcement& peer);
  /// This session will announce the channel in another way than before.
  void OwnChanged(const std::string& channel);
  /// The session is not found any more.
  void Lost(const Announcement& last);
  /// After a while, the session is no longer left to transports of this host that do not reach it, and this is
  /// reported.
  void Await(SessionId peer);

 private:
  // If it is then still not reached, this is reported even without a cause that is sure to last.
  static constexpr auto kLongPatience = std::chrono::seconds(8);

  [[nodiscard]] TransportSet Expected(const Announcement& peer) const;
  using Use = StrangerChannels::Use;
  [[nodiscard]] Use UseOf(SessionId session, const ChannelAnnouncement& channel) const;
  [[nodiscard]] bool Exchange(const ChannelAnnouncement& ours, const Use& theirs) const;
  // Now, as far as the announcements tell.
  [[nodiscard]] bool Exchanges(const Announcement& peer) const;
  void Remember(const Announcement& stranger);
  void Connect(const Announcement& peer);
  void GiveUp(SessionId peer);
  void ReportIfUnreached(SessionId peer, const PeerTransports::GivenUp& given_up, bool finally);
  [[nodiscard]] std::string Obstacle(const Announcement& peer, TransportSet missing) const;
  // Runs the errand after a delay. If this process was not running meanwhile, the others get the same time once more.
  void Later(std::chrono::nanoseconds delay, std::function<void()> errand);

  const Means means_;
  StrangerChannels strangers_;
  std::atomic<bool> giving_up_{false};  // An errand gives up sessions that exchange nothing with this one.
};

}  // namespace hgros
