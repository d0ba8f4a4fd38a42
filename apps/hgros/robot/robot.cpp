#include "robot/robot.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "hgros/session/snapshot_message.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerTime{1};
constexpr std::chrono::seconds kConnectTime{3};

// The configuration of this session: whom it meets. What a file says of its own robot's nodes, channels and publishing
// endpoints belongs to the sessions of the robot.
Config ConfigOf(const RobotOptions& options) {
  Config config;
  if (!options.config.empty()) {
    const std::vector<std::filesystem::path> files(options.config.begin(), options.config.end());
    Config read = Config::Load(files);
    config.subscribers = std::move(read.subscribers);
    config.security = std::move(read.security);
    config.discovery = std::move(read.discovery);
    config.heartbeat_ms = read.heartbeat_ms;
    config.peer_timeout_ms = read.peer_timeout_ms;
  }
  for (EndpointConfig& endpoint : config.subscribers) endpoint.all_channels = true;
  for (const std::string& endpoint : options.connect) {
    const std::string with_scheme = endpoint.find("://") == std::string::npos ? "tcp://" + endpoint : endpoint;
    const auto known = [&](const EndpointConfig& one) { return one.endpoint == with_scheme; };
    if (std::ranges::none_of(config.subscribers, known)) config.subscribers.push_back({with_scheme, {}, true});
  }
  std::ranges::sort(config.subscribers, {}, &EndpointConfig::endpoint);
  return config;
}

bool IsOwn(std::string_view channel) { return channel.starts_with("hgros/"); }

}  // namespace

Robot::Robot(const RobotOptions& options, const Surroundings& surroundings)
    : surroundings_(surroundings), options_(options) {
  if (!options.domain.empty()) setenv("HGROS_DOMAIN", options.domain.c_str(), 1);  // NOLINT: there are no threads yet.
  Console& console = surroundings_.console;
  const LogSink log = [&console](LogLevel level, std::string_view text) {
    if (level >= LogLevel::kWarning) console.Say(text);
  };
  session_ = std::make_unique<Session>(ConfigOf(options), SessionOptions{"hgros", log});
  subscription_ =
      session_->FromAny<Snapshot>(kSnapshotsChannel, Invoke::kSerial,
                                  [this](const std::shared_ptr<const Snapshot>& snapshot, const MessageInfo& info) {
                                    const std::scoped_lock lock(mutex_);
                                    counters_[SessionId{info.id.publisher}] = snapshot;
                                    surroundings_.pause.Wake();
                                  },
                                  {.executor = Executor::Inline()});
  AwaitEndpoints(options);
}

void Robot::AwaitEndpoints(const RobotOptions& options) {
  const auto deadline = std::chrono::steady_clock::now() + options.Timeout(kConnectTime);
  for (const EndpointConfig& endpoint : session_->config().subscribers) {
    const auto answers = [&] {
      return std::ranges::any_of(session_->Peers(),
                                 [&](const PeerInfo& peer) { return peer.endpoint == endpoint.endpoint; });
    };
    while (!answers()) {
      const auto end = surroundings_.pause.Until(
          std::min(deadline, std::chrono::steady_clock::now() + std::chrono::milliseconds(20)));
      if (end == Pause::End::kInterrupted) return;
      if (std::chrono::steady_clock::now() < deadline) continue;
      throw Error("No session answers at " + endpoint.endpoint +
                  ". Is the program running, and is this the address of one of its "
                  "publisher endpoints?");
    }
  }
}

std::vector<KnownChannel> Robot::Channels(bool own) const {
  std::vector<KnownChannel> channels = session_->Channels();
  const auto is_ours = [this](const ChannelUser& user) { return user.session == session_->id(); };
  for (KnownChannel& channel : channels) {
    std::erase_if(channel.publishers, is_ours);
    std::erase_if(channel.subscribers, is_ours);
  }
  std::erase_if(channels, [own](const KnownChannel& channel) {
    return (channel.publishers.empty() && channel.subscribers.empty()) || (!own && IsOwn(channel.name));
  });
  return channels;
}

std::vector<ChannelUser> Robot::Unheard() const {
  std::vector<ChannelUser> unheard;
  for (const KnownChannel& channel : Channels(true)) {
    if (channel.name != kSnapshotsChannel) continue;
    const std::scoped_lock lock(mutex_);
    for (const ChannelUser& user : channel.publishers) {
      if (!counters_.contains(user.session)) unheard.push_back(user);
    }
  }
  return unheard;
}

std::map<SessionId, std::shared_ptr<const Snapshot>> Robot::Counters() {
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(kAnswerTime);
  std::vector<ChannelUser> unheard;
  while (!waited_ && !(unheard = Unheard()).empty() && AwaitCounters(deadline)) {
  }
  if (!waited_) {
    for (const ChannelUser& user : Unheard()) {
      surroundings_.console.Say("Session " + SessionName(user.session, user.process, user.pid, user.host) +
                                " does not answer; its counters are missing.");
    }
  }
  waited_ = true;
  const std::scoped_lock lock(mutex_);
  return counters_;
}

bool Robot::AwaitCounters(std::chrono::steady_clock::time_point deadline) {
  return surroundings_.pause.Until(deadline) == Pause::End::kWoken;
}

}  // namespace hgros::cli
