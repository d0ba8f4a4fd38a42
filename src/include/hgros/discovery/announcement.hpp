#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/internal/codec/channel_use.hpp"

namespace hgros {

namespace discovery {
inline constexpr std::size_t kMaxAnnouncedTextBytes = 256;  // Limit of displayed names and endpoints.
}  // namespace discovery

/// A session's use of one channel, and the transports that may carry it.
struct ChannelAnnouncement : ChannelUse {
  TransportKeys transports = {};  ///< The transports that it may use.

  bool operator==(const ChannelAnnouncement&) const = default;
};

/// A session: its identity, where it can be reached, and what it publishes and subscribes to.
struct Announcement {
  SessionId session;
  std::uint64_t incarnation = 0;  ///< Distinguishes restarts with the same session id; grows.
  std::string process;            ///< Its program's name, for logs.
  std::string host;               ///< Its host's name. Only shown, never compared.
  std::int64_t pid = 0;
  std::uint64_t pid_start_time = 0;  ///< In clock ticks since the host started; 0: unknown.
  std::string boot_id;               ///< Equal for all processes of a host until it restarts; empty: unknown.
  std::uint64_t network = 0;         ///< Equal for all processes of a host in one network namespace; 0: unknown.
  /// Where transports of its host find it, by their keys.
  std::map<std::string, std::string, std::less<>> places;
  std::vector<std::string> endpoints;  ///< ZeroMQ's: "ipc:///path", "tcp://host:port".
  std::string sender;                  ///< The address that a beacon heard it from; empty: not from a beacon.
  std::vector<std::string> senders;    ///< If beacons came from several addresses: for each endpoint, where from.
  std::vector<ChannelAnnouncement> channels;
  /// Processes of this host that the session wants to reach, by their names; empty: all.
  std::vector<std::string> only;

  bool operator==(const Announcement&) const = default;
};

/// An announcement of `session` with everything filled in that the operating system knows about this process.
[[nodiscard]] HGROS_EXPORT Announcement AnnouncementOfThisProcess(SessionId session, std::uint64_t incarnation);

}  // namespace hgros
