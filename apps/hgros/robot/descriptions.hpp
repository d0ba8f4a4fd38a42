#pragma once

#include <string>
#include <vector>

#include "robot/overview.hpp"
#include "terminal/console.hpp"
#include "terminal/sheet.hpp"

namespace hgros::cli {

/// A robot at one moment, as far as this command knows it.
struct KnownRobot {
  AllCounters counters;
  std::vector<KnownChannel> channels;  ///< With those of the library.
  OutputStyle style;
};

[[nodiscard]] Sheet DescribeChannel(const KnownRobot& robot, const KnownChannel& channel);
/// A session whose counters may be missing.
[[nodiscard]] Sheet DescribeSession(const KnownRobot& robot, const ChannelUser& session);
/// A node of a session whose counters are known.
[[nodiscard]] Sheet DescribeNode(const KnownRobot& robot, SessionId session, const Snapshot::Channel& channel,
                                 const Snapshot::Node& node);
/// `channel` carries the calls of a service.
[[nodiscard]] Sheet DescribeService(const KnownRobot& robot, const KnownChannel& channel);

/// All sessions that use a channel, by id.
[[nodiscard]] std::map<SessionId, ChannelUser> SessionsOf(const std::vector<KnownChannel>& channels);
[[nodiscard]] bool AreOnSeveralHosts(const std::map<SessionId, ChannelUser>& sessions);

}  // namespace hgros::cli
