#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <hgros/Snapshot.pb.h>

#include "arguments/command.hpp"
#include "hgros/hgros.hpp"
#include "robot/robot_options.hpp"

namespace hgros::cli {

/// The running robot as a command sees it: a session of its own among those of the robot.
///
/// Threading: the thread of the command.
class Robot {
 public:
  /// Waits for the sessions behind --connect. Throws Error or UsageError.
  Robot(const RobotOptions& options, const Surroundings& surroundings);

  [[nodiscard]] Session& session() noexcept { return *session_; }
  [[nodiscard]] const Surroundings& surroundings() const noexcept { return surroundings_; }
  /// All channels that other sessions use, sorted by name. `own`: also those of the library itself. With `lan: true`
  /// the first call waits up to a second, or half of --timeout, for sessions of other hosts.
  [[nodiscard]] std::vector<KnownChannel> Channels(bool own) const;
  /// Says which of the channels nobody publishes on, with the nearest name. Somebody may begin later, so it is no
  /// error.
  void SayUnpublished(const std::vector<std::string>& channels) const;
  /// The newest counters of each session that answers, by session. The first call waits for all of them. Says which
  /// sessions did not answer within a second, or within half of --timeout.
  [[nodiscard]] std::map<SessionId, std::shared_ptr<const Snapshot>> Counters();
  /// The sessions that did not answer.
  [[nodiscard]] const std::map<SessionId, ChannelUser>& silent() const noexcept { return silent_; }
  /// Waits for the next counters of any session. False if the time is over or the user ended the command.
  [[nodiscard]] bool AwaitCounters(std::chrono::steady_clock::time_point deadline);

 private:
  // Whether --connect names it.
  [[nodiscard]] bool IsRequired(const EndpointConfig& endpoint) const;
  // Throws if the host of --connect has no address. Drops endpoints of --config whose hosts have none.
  void RequireAddresses(Config& config) const;
  void AwaitEndpoints();
  void AwaitOtherHosts() const;
  // Whether any other session is known.
  [[nodiscard]] bool MeetsSomebody() const;
  void AwaitEndpoint(const std::string& endpoint, std::chrono::steady_clock::time_point deadline, bool required);
  // The sessions that publish counters.
  [[nodiscard]] std::map<SessionId, ChannelUser> Countable() const;

  const Surroundings surroundings_;
  const RobotOptions& options_;
  std::unique_ptr<Session> session_;
  std::chrono::steady_clock::time_point other_hosts_by_{};  // Until then they may be found.
  mutable std::mutex mutex_;                                // Guards the next.
  std::map<SessionId, std::shared_ptr<const Snapshot>> counters_;
  std::map<SessionId, ChannelUser> silent_;
  bool waited_ = false;
  Subscription subscription_;  // Ends first.
};

}  // namespace hgros::cli
