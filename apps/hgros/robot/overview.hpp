#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <hgros/Snapshot.pb.h>

#include "hgros/base/ids.hpp"
#include "hgros/bridge/known_channel.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {

using AllCounters = std::map<SessionId, std::shared_ptr<const Snapshot>>;

/// The counters of a session on one channel; null if it has none.
[[nodiscard]] const Snapshot::Channel* CountersOf(const AllCounters& counters, SessionId session,
                                                  std::string_view channel);

/// The same in one snapshot, which may be null.
[[nodiscard]] const Snapshot::Channel* CountersIn(const Snapshot* counters, std::string_view channel);

/// The channel with that name; without users if there is none.
[[nodiscard]] KnownChannel ChannelNamed(const std::vector<KnownChannel>& channels, const std::string& name);

/// Several nodes of a channel may have one name: the one with that name and this place among them. Null if there is
/// none, or no channel.
[[nodiscard]] const Snapshot::Node* FindNode(const Snapshot::Channel* channel, std::string_view name,
                                             std::size_t place);

/// What the sessions that use a channel count, together.
struct ChannelTotals {
  bool known = false;  ///< At least one publisher's counters are known.
  double rate_hz = 0;
  std::uint64_t published = 0;
  std::uint64_t latched = 0;
  std::uint64_t encoded = 0;          ///< Messages written for other sessions.
  std::uint64_t encoded_bytes = 0;    ///< The bytes of these.
  std::uint64_t far_subscribers = 0;  ///< Sessions beyond those that are known, such as on other hosts.
  std::uint64_t far_publishers = 0;
  std::uint64_t refused = 0;  ///< Messages that subscribers did not take, because their type is another one.
};
[[nodiscard]] ChannelTotals TotalsOf(const AllCounters& counters, const KnownChannel& channel);

/// How the messages of one session come to another.
struct Way {
  std::string transport;  ///< "process", "shared memory" or "ZeroMQ"; empty: unknown.
  std::string why;        ///< Why that transport was chosen; may be empty.
};
[[nodiscard]] Way WayBetween(const AllCounters& counters, SessionId publisher, SessionId subscriber);
/// The transports over which a channel's messages go, each once.
[[nodiscard]] std::vector<std::string> TransportsOf(const AllCounters& counters, const KnownChannel& channel);

/// Whether the channel belongs to the library itself: services, counters, parameters.
[[nodiscard]] bool IsInternal(std::string_view channel) noexcept;

/// The name of a service if the channel carries its calls, or empty.
[[nodiscard]] std::string_view ServiceOf(std::string_view channel) noexcept;
/// The name under which parameters are offered if the channel carries their state, or empty.
[[nodiscard]] std::string_view ParamsOf(std::string_view channel) noexcept;

/// "talker:4711", or "talker:4711@desk" if there is a host.
[[nodiscard]] std::string ShortName(std::string_view process, std::int64_t pid, std::string_view host = {});
[[nodiscard]] std::string ShortName(const ChannelUser& user, bool with_host);

/// The session that has sent these counters.
[[nodiscard]] ChannelUser UserOf(const Snapshot& counters);
/// The columns that say which session it is, and their cells: tables show the short name, and JSON has process, pid,
/// host and session.
[[nodiscard]] std::vector<Column> UserColumns(const std::string& heading);
[[nodiscard]] std::vector<Cell> UserCells(const ChannelUser& user, bool with_host);

/// One session, or a list of them, in a single cell: tables show the short names, and JSON has objects with process,
/// pid, host and session.
[[nodiscard]] Cell UserCell(const ChannelUser& user);
[[nodiscard]] Cell UserListCell(const std::vector<ChannelUser>& users);

}  // namespace hgros::cli
