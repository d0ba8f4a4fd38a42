#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "discovery/beacon/beacon_peers.hpp"
#include "discovery/beacon/beacon_socket.hpp"
#include "discovery/peer_book.hpp"
#include "discovery/wake_event.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/discovery/beacon.hpp"

namespace hgros::discovery {

/// The beacon's thread.
///
/// Thread safety: Announce(), List() and in_forked_child().
class BeaconCore {
 public:
  BeaconCore(const BeaconOptions& options, DiscoveryListener& listener, Log& log);
  BeaconCore(const BeaconCore&) = delete;
  BeaconCore& operator=(const BeaconCore&) = delete;
  ~BeaconCore();

  void Announce(const Announcement& own);
  [[nodiscard]] std::vector<Announcement> List(const Discovery::Which& which) const { return book_.List(which); }
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }

 private:
  using Clock = std::chrono::steady_clock;

  void Loop();
  void RefreshInterfaces();
  void RefillBudget(Clock::time_point now);
  [[nodiscard]] Clock::time_point Deadline() const;
  void HearAll();
  void Answer();
  void SendIfDue();
  void Send(const std::string& datagram);

  const BeaconOptions options_;
  DiscoveryListener& listener_;
  Log& log_;
  const ForkGuard fork_;
  PeerBook book_;
  BeaconSocket socket_;
  mutable std::mutex mutex_;
  std::optional<Announcement> own_;  // Guarded by mutex_, like the next three.
  std::string datagram_;
  Clock::time_point last_sent_;
  Clock::time_point next_send_;
  BeaconPeers peers_;  // Only the thread uses it and the members below.
  Clock::time_point next_refresh_;
  std::set<std::string> said_;  // About interfaces.
  Clock::time_point refilled_;
  int budget_ = 0;  // What may be read before the next refill.
  std::minstd_rand random_;
  WakeEvent wake_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace hgros::discovery
