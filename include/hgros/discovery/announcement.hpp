#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// What a session does with one channel.
struct ChannelAnnouncement {
  std::string channel;
  std::string type_name;
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown.
  bool publishes = false;
  bool subscribes = false;
  bool lossless = false;         ///< As a subscriber: nothing may be dropped.
  bool by_shared_memory = true;  ///< May pass through shared memory.
  bool by_endpoints = true;      ///< May pass over the endpoints.

  bool operator==(const ChannelAnnouncement&) const = default;
};

/// Who a session is, where it can be reached, and what it offers and wants.
struct Announcement {
  SessionId session;
  std::uint64_t incarnation = 0;  ///< Distinguishes lives of one session id; grows.
  std::string process;            ///< For people.
  std::string host;               ///< For people, never compared.
  std::int64_t pid = 0;
  std::uint64_t pid_start_time = 0;    ///< In clock ticks since the host started; 0: unknown.
  std::string boot_id;                 ///< Equal on one host between two starts of it; empty: unknown.
  std::string shared_memory;           ///< The place of its shared-memory carrier; empty: it has none.
  std::vector<std::string> endpoints;  ///< ZeroMQ's: "ipc:///path", "tcp://host:port".
  std::vector<ChannelAnnouncement> channels;
  /// Processes of this host that the session wants to do with, as they name themselves; empty: all.
  std::vector<std::string> only;

  bool operator==(const Announcement&) const = default;
};

/// An announcement of `session` with everything filled in that the operating system knows of this process.
[[nodiscard]] HGROS_EXPORT Announcement AnnouncementOfThisProcess(SessionId session, std::uint64_t incarnation);

}  // namespace hgros
