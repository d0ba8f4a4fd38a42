#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/discovery/discovery.hpp"

namespace hgros {

/// What this session announces of itself, and the registry and the beacon that tell it to others.
///
/// Thread safety: all functions.
class Announcer {
 public:
  /// On this host the session connects with the processes that `only` names; with all if it is empty. `log` outlives
  /// it.
  Announcer(SessionId session, const std::string& process, std::vector<std::string> only, Log& log);

  /// Others find it there from now on.
  void SetPlace(const std::string& transport_key, const std::string& place);
  void SetEndpoints(std::vector<std::string> endpoints);
  /// The session publishes or subscribes to the channel, over these transports only.
  void Publishes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports);
  void Subscribes(const std::string& channel, const TypeInfo& type, const TransportKeys& transports, bool lossless);
  /// It no longer does.
  void EndPublishing(const std::string& channel);
  void EndSubscribing(const std::string& channel);

  /// Tells them at once. The registry of this host can be read as well.
  void UseRegistry(std::unique_ptr<Discovery> registry);
  void UseBeacon(std::unique_ptr<Discovery> beacon);
  /// Ends both: nobody is found any more.
  void Close() noexcept;
  /// Tells others what has changed.
  void Announce();

  /// The sessions of this host that this one is to connect with.
  [[nodiscard]] std::vector<Announcement> PeersOnHost() const;
  /// False if this session or that one names the processes that it connects with, and the other is not among them.
  [[nodiscard]] bool IsWanted(const Announcement& peer) const;
  /// This session does not want the peer, whatever the peer wants.
  [[nodiscard]] bool IsExcludedHere(const Announcement& peer) const;
  [[nodiscard]] Announcement own() const;

 private:
  [[nodiscard]] ChannelAnnouncement& Channel(const std::string& channel, const TypeInfo& type,
                                             const TransportKeys& transports);
  void Tell(Discovery& discovery, const std::string& listeners);

  Log& log_;
  const std::string process_;
  const std::vector<std::string> only_;
  mutable std::mutex mutex_;  // Guards what follows: a subscription may end while the session does.
  Announcement own_;
  std::unique_ptr<Discovery> registry_;
  std::unique_ptr<Discovery> beacon_;
};

}  // namespace hgros
