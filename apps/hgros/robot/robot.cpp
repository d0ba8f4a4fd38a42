#include "robot/robot.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "robot/overview.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerTime{1};
constexpr std::chrono::seconds kConnectTime{3};

// The configuration of this session: whom it meets. What a file says of its own robot's nodes, channels and publishing
// endpoints belongs to the sessions of the robot.
Config ConfigOf(const RobotOptions& options) {
  Config config;
  config.control = false;
  if (!options.config.empty()) {
    const std::vector<std::filesystem::path> files(options.config.begin(), options.config.end());
    Config read = Config::Load(files);
    config.subscribers = std::move(read.subscribers);
    if (options.sends) config.publishers = std::move(read.publishers);
    config.security = std::move(read.security);
    config.discovery = std::move(read.discovery);
    config.heartbeat_ms = read.heartbeat_ms;
    config.peer_timeout_ms = read.peer_timeout_ms;
  }
  for (auto* endpoints : {&config.publishers, &config.subscribers}) {
    for (EndpointConfig& endpoint : *endpoints) endpoint.all_channels = true;
  }
  for (const std::string& endpoint : options.connect) {
    const std::string with_scheme = endpoint.find("://") == std::string::npos ? "tcp://" + endpoint : endpoint;
    const auto known = [&](const EndpointConfig& one) { return one.endpoint == with_scheme; };
    if (std::ranges::none_of(config.subscribers, known)) config.subscribers.push_back({with_scheme, {}, true});
  }
  std::ranges::sort(config.subscribers, {}, &EndpointConfig::endpoint);
  return config;
}

// Whether a connection to "tcp://HOST:PORT" is accepted now.
bool SomebodyListensAt(const std::string& endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon <= kTcp.size()) return false;
  const std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), endpoint.c_str() + colon + 1, &hints, &found) != 0) return false;
  bool accepted = false;
  for (const addrinfo* one = found; one != nullptr && !accepted; one = one->ai_next) {
    const int fd = socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) continue;
    if (connect(fd, one->ai_addr, one->ai_addrlen) == 0 || errno == EINPROGRESS) {
      pollfd connected{fd, POLLOUT, 0};
      accepted = poll(&connected, 1, 200) == 1 && (connected.revents & (POLLERR | POLLHUP)) == 0;
    }
    close(fd);
  }
  freeaddrinfo(found);
  return accepted;
}

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
  AwaitEndpoints();
}

// A session that is met in shared memory, too, is not listed with its endpoint. Then it is enough that something
// listens there.
void Robot::AwaitEndpoint(const std::string& endpoint, std::chrono::steady_clock::time_point deadline, bool required) {
  const auto answers = [&] {
    return std::ranges::any_of(session_->Peers(), [&](const PeerInfo& peer) { return peer.endpoint == endpoint; });
  };
  const auto second = std::min(deadline, std::chrono::steady_clock::now() + std::chrono::seconds(1));
  while (!answers()) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= second && now < deadline && SomebodyListensAt(endpoint)) return;
    if (now >= deadline) break;
    if (surroundings_.pause.Until(std::min(now >= second ? deadline : second, now + std::chrono::milliseconds(20))) ==
        Pause::End::kInterrupted) {
      throw OutputClosed();
    }
  }
  if (answers() || SomebodyListensAt(endpoint)) return;
  const std::string what = "No session answers at " + endpoint +
                           ". Is the program running, and is this the address of one of its publisher endpoints?";
  if (!required) return surroundings_.console.Say(what);
  if (options_.timeout_s) throw TimedOut(what);
  throw Error(what);
}

void Robot::AwaitEndpoints() {
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(kConnectTime);
  for (const EndpointConfig& endpoint : session_->config().subscribers) {
    const bool required =
        std::ranges::any_of(options_.connect, [&](const std::string& one) { return endpoint.endpoint.ends_with(one); });
    AwaitEndpoint(endpoint.endpoint, deadline, required);
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
    return (channel.publishers.empty() && channel.subscribers.empty()) || (!own && IsInternal(channel.name));
  });
  return channels;
}

void Robot::SayUnpublished(const std::vector<std::string>& channels) const {
  std::vector<std::string> published;
  for (const KnownChannel& channel : Channels(true)) {
    if (!channel.publishers.empty()) published.push_back(channel.name);
  }
  for (const std::string& name : channels) {
    if (std::ranges::find(published, name) != published.end()) continue;
    const std::string nearest = NearestName(name, published);
    surroundings_.console.Say("Nobody publishes on " + Visible(name) + " yet." +
                              (nearest.empty() ? "" : " Did you mean " + Visible(nearest) + "?"));
  }
}

std::map<SessionId, ChannelUser> Robot::Countable() const {
  std::map<SessionId, ChannelUser> countable;
  for (const KnownChannel& channel : session_->Channels()) {
    if (channel.name != kSnapshotsChannel) continue;
    for (const ChannelUser& user : channel.publishers) {
      if (user.session != session_->id()) countable.emplace(user.session, user);
    }
  }
  return countable;
}

std::map<SessionId, std::shared_ptr<const Snapshot>> Robot::Counters() {
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(kAnswerTime);
  std::map<SessionId, ChannelUser> countable = Countable();
  const auto unheard = [&] {
    const std::scoped_lock lock(mutex_);
    return std::ranges::any_of(countable, [this](const auto& one) { return !counters_.contains(one.first); });
  };
  while (!waited_ && unheard() && AwaitCounters(deadline)) {
  }
  const std::scoped_lock lock(mutex_);
  // Of sessions that have ended.
  std::erase_if(counters_, [&](const auto& one) { return !countable.contains(one.first); });
  for (const auto& [session, user] : countable) {
    if (!counters_.contains(session) && silent_.emplace(session, user).second) {
      surroundings_.console.Say("Session " + Visible(SessionName(session, user.process, user.pid, user.host)) +
                                " does not answer; its counters are missing.");
    }
  }
  waited_ = true;
  return counters_;
}

bool Robot::AwaitCounters(std::chrono::steady_clock::time_point deadline) {
  return surroundings_.pause.Until(deadline) == Pause::End::kWoken;
}

}  // namespace hgros::cli
