#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// This session's announcement, and the registry and the beacon that pass it to others.
///
/// Thread safety: all functions.
class Announcer {
 public:
  /// Runs an errand after a delay, on another thread.
  using Later = std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)>;

  /// On this host the session connects with the processes that `only` names, or with all if it is empty. `log`
  /// outlives it. No errand may run after its end.
  Announcer(SessionId session, const std::string& process, std::vector<std::string> only, Later later, Log& log);

  /// From now on others find the session at this place.
  void SetPlace(const std::string& transport_key, const std::string& place);
  void SetEndpoints(std::vector<std::string> endpoints);
  /// The session publishes or subscribes to the channel, over these transports only.
  void Publishes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports);
  void Subscribes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports, bool lossless);
  /// Whether the subscribing session asks for lossless delivery now. Returns true if that is new.
  [[nodiscard]] bool SetLossless(const std::string& channel, bool lossless);
  /// The session no longer publishes or subscribes to the channel.
  void EndPublishing(const std::string& channel);
  void EndSubscribing(const std::string& channel);

  /// Passes changes to them at once. The registry of this host can be read from now on, and gets changes after
  /// AppearOnHost(). After Close(), nothing is used.
  void UseRegistry(std::unique_ptr<Discovery> registry);
  /// Makes this session known on this host, unless it is already, or there is no registry. Throws Error if the registry
  /// cannot be written.
  void AppearOnHost();
  void UseBeacon(std::unique_ptr<Discovery> beacon);
  /// Ends both: no further session is found.
  void Close() noexcept;
  /// Passes the changes to others, at once or within milliseconds.
  void Announce();

  /// The sessions of this host that neither side's list excludes; only those for which `which` returns true, if it is
  /// set. `which` is called under a lock.
  [[nodiscard]] std::vector<Announcement> PeersOnHost(const Discovery::Which& which = {}) const;
  /// False if either session names the processes that it connects with, and the other one is not among them.
  [[nodiscard]] bool IsWanted(const Announcement& peer) const;
  /// True if this session's own list excludes the peer.
  [[nodiscard]] bool IsExcludedHere(const Announcement& peer) const;
  [[nodiscard]] Announcement own() const;
  /// How this session announces the channel; empty if it does not use it.
  [[nodiscard]] std::optional<ChannelAnnouncement> OwnChannel(const std::string& channel) const;

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] ChannelAnnouncement& Channel(const std::string& channel, const TypeInfo& type,
                                             const TransportKeys& transports);
  void EndUse(const std::string& channel, bool ChannelUse::*use);
  void TellAll();
  void Tell(Discovery& discovery, const std::string& listeners);

  Log& log_;
  const std::string process_;
  const std::vector<std::string> only_;
  const Later later_;
  mutable std::mutex mutex_;  // Guards what follows: a subscription may end while the session does.
  Announcement own_;
  std::unordered_map<std::string, std::size_t> places_;  // In own_.channels, by channel.
  Clock::time_point next_{};                             // No announcement before this time.
  bool waits_ = false;                                   // An errand will announce.
  std::unique_ptr<Discovery> registry_;
  std::unique_ptr<Discovery> beacon_;
  bool on_host_ = false;  // Others of this host can find this session.
  bool closed_ = false;
};

/// The session that announces itself, as peers are described.
[[nodiscard]] PeerInfo InfoOf(const Announcement& peer);

}  // namespace hgros
