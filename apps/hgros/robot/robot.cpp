#include "robot/robot.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "robot/overview.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerTime{1};
constexpr std::chrono::seconds kConnectTime{3};

// The configuration of this session: whom it meets. What a file says of its own robot's nodes, channels and publishing
// endpoints belongs to the sessions of the robot. What the environment says is for this one, in a program of a robot.
Config ConfigOf(const RobotOptions& options) {
  Config config;
  const std::vector<std::filesystem::path> files(options.config.begin(), options.config.end());
  Config read = files.empty() ? Config::OfEnvironment() : Config::Load(files);
  config.subscribers = std::move(read.subscribers);
  if (options.sends || files.empty()) config.publishers = std::move(read.publishers);
  config.security = std::move(read.security);
  config.discovery = std::move(read.discovery);
  config.heartbeat_ms = read.heartbeat_ms;
  config.peer_timeout_ms = read.peer_timeout_ms;
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

// "HOST" of "tcp://HOST:PORT" if it is a name; otherwise empty.
std::string HostNameIn(const std::string& endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon <= kTcp.size()) return {};
  std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  addrinfo numeric{};
  numeric.ai_flags = AI_NUMERICHOST;
  addrinfo* found = nullptr;
  const bool is_name = host.front() != '[' && getaddrinfo(host.c_str(), nullptr, &numeric, &found) != 0;
  if (found != nullptr) freeaddrinfo(found);
  return is_name ? host : std::string();
}

// Asks what a name's address is. The answer may take many seconds, and nothing can end the question. So a thread of its
// own asks, which nobody joins: it may outlive the command.
class NameQuestion {
 public:
  explicit NameQuestion(const std::string& host) {
    std::thread([answer = answer_, host] {
      addrinfo hints{};
      hints.ai_socktype = SOCK_STREAM;
      addrinfo* found = nullptr;
      const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
      if (error == 0) freeaddrinfo(found);
      const std::scoped_lock lock(answer->mutex);
      answer->fault = error == 0 ? "" : gai_strerror(error);
      answer->came.notify_all();
    }).detach();
  }
  // Why there is no address; empty: there is one. No value: the answer has not come.
  [[nodiscard]] std::optional<std::string> Await(std::chrono::steady_clock::time_point deadline) const {
    std::unique_lock lock(answer_->mutex);
    answer_->came.wait_until(lock, deadline, [this] { return answer_->fault.has_value(); });
    return answer_->fault;
  }

 private:
  struct Answer {
    std::mutex mutex;
    std::condition_variable came;
    std::optional<std::string> fault;  // Guarded by mutex.
  };
  const std::shared_ptr<Answer> answer_ = std::make_shared<Answer>();
};

bool Accepts(const sockaddr* address, socklen_t size) {
  const int fd = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  bool accepted = false;
  if (connect(fd, address, size) == 0 || errno == EINPROGRESS) {
    pollfd connected{fd, POLLOUT, 0};
    accepted = poll(&connected, 1, 200) == 1 && (connected.revents & (POLLERR | POLLHUP)) == 0;
  }
  close(fd);
  return accepted;
}

// Whether a connection to "tcp://HOST:PORT" or "ipc://PATH" is accepted now.
bool SomebodyListensAt(const std::string& endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  constexpr std::string_view kIpc = "ipc://";
  if (endpoint.starts_with(kIpc)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = endpoint.substr(kIpc.size());
    if (path.size() >= sizeof(address.sun_path)) return false;
    std::ranges::copy(path, std::begin(address.sun_path));
    if (path.starts_with('@')) address.sun_path[0] = '\0';  // A name that is no file.
    const std::size_t size = offsetof(sockaddr_un, sun_path) + path.size() + (path.starts_with('@') ? 0 : 1);
    return Accepts(reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(size));
  }
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon <= kTcp.size()) return false;
  const std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), endpoint.c_str() + colon + 1, &hints, &found) != 0) return false;
  bool accepted = false;
  for (const addrinfo* one = found; one != nullptr && !accepted; one = one->ai_next) {
    accepted = Accepts(one->ai_addr, one->ai_addrlen);
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
  Config config = ConfigOf(options);
  RequireAddresses(config);
  session_ = std::make_unique<Session>(config, SessionOptions{"hgros", log});
  subscription_ =
      session_->FromAny<Snapshot>(kSnapshotsChannel, Invoke::kSerial,
                                  [this](const std::shared_ptr<const Snapshot>& snapshot, const MessageInfo& info) {
                                    const std::scoped_lock lock(mutex_);
                                    counters_[SessionId{info.id.publisher}] = snapshot;
                                    surroundings_.pause.Wake();
                                  },
                                  {.executor = Executor::Inline()});
  other_hosts_by_ = std::chrono::steady_clock::now() +
                    std::min<std::chrono::nanoseconds>(options.Timeout(2 * kAnswerTime) / 2, kAnswerTime);
  AwaitEndpoints();
}

bool Robot::IsRequired(const EndpointConfig& endpoint) const {
  return std::ranges::any_of(options_.connect,
                             [&](const std::string& one) { return endpoint.endpoint.ends_with(one); });
}

// A session asks for addresses, too, and does not end before the answer.
void Robot::RequireAddresses(Config& config) const {
  std::map<std::string, NameQuestion> questions;
  for (const EndpointConfig& endpoint : config.subscribers) {
    if (const std::string host = HostNameIn(endpoint.endpoint); !host.empty()) questions.try_emplace(host, host);
  }
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(kConnectTime);
  constexpr std::chrono::milliseconds kSlice{50};  // Ctrl-C must not wait longer.
  for (const auto& [host, question] : questions) {
    const Progress progress(surroundings_.console, surroundings_.pause, "waiting for the address of " + Visible(host),
                            deadline - std::chrono::steady_clock::now());
    std::optional<std::string> fault;
    do {
      fault = question.Await(std::min(deadline, std::chrono::steady_clock::now() + kSlice));
      if (surroundings_.pause.For({}) == Pause::End::kInterrupted) throw OutputClosed();
    } while (!fault && std::chrono::steady_clock::now() < deadline);
    if (fault == "") continue;
    const auto is_there = [&host = host](const EndpointConfig& one) { return HostNameIn(one.endpoint) == host; };
    const std::string what = "The address of " + host +
                             " is not known: " + (fault ? *fault + "." : "no name server answers in time.") +
                             " Is the name right?";
    const bool required = std::ranges::any_of(
        config.subscribers, [&](const EndpointConfig& one) { return is_there(one) && IsRequired(one); });
    if (required && fault) throw Error(what);
    if (required) options_.GiveUp(what);
    surroundings_.console.Say(what);
    std::erase_if(config.subscribers, is_there);
  }
}

bool Robot::MeetsSomebody() const {
  if (!session_->Peers().empty()) return true;
  const auto other = [this](const ChannelUser& user) { return user.session != session_->id(); };
  return std::ranges::any_of(session_->Channels(), [&](const KnownChannel& channel) {
    return std::ranges::any_of(channel.publishers, other) || std::ranges::any_of(channel.subscribers, other);
  });
}

// A session that is met in shared memory, too, or has connected to this one first, is not listed with its endpoint.
// Then it is enough that something listens there.
void Robot::AwaitEndpoint(const std::string& endpoint, std::chrono::steady_clock::time_point deadline, bool required) {
  const auto answers = [&] {
    return std::ranges::any_of(session_->Peers(), [&](const PeerInfo& peer) { return peer.endpoint == endpoint; });
  };
  const Progress progress(surroundings_.console, surroundings_.pause, "waiting for a session at " + Visible(endpoint),
                          deadline - std::chrono::steady_clock::now());
  const auto second = std::min(deadline, std::chrono::steady_clock::now() + std::chrono::seconds(1));
  while (!answers()) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= second && now < deadline && MeetsSomebody() && SomebodyListensAt(endpoint)) return;
    if (now >= deadline) break;
    if (surroundings_.pause.Until(std::min(now >= second ? deadline : second, now + std::chrono::milliseconds(20))) ==
        Pause::End::kInterrupted) {
      throw OutputClosed();
    }
  }
  if (answers()) return;
  const bool listens = SomebodyListensAt(endpoint);
  if (listens && MeetsSomebody()) return;
  const std::string what =
      "No session answers at " + endpoint +
      (listens
           ? ", although a program listens there. It may refuse the key of this command, ask for one, or be stopped."
           : ". Is the program running, and is this the address of one of its publisher endpoints?");
  if (!required) return surroundings_.console.Say(what);
  options_.GiveUp(what);
}

void Robot::AwaitEndpoints() {
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(kConnectTime);
  for (const EndpointConfig& endpoint : session_->config().subscribers) {
    AwaitEndpoint(endpoint.endpoint, deadline, IsRequired(endpoint));
  }
}

// Nobody knows how many there are.
void Robot::AwaitOtherHosts() const {
  if (!session_->config().discovery.lan || std::chrono::steady_clock::now() >= other_hosts_by_) return;
  const Progress progress(surroundings_.console, surroundings_.pause, "waiting for sessions of other hosts",
                          other_hosts_by_ - std::chrono::steady_clock::now());
  while (std::chrono::steady_clock::now() < other_hosts_by_) {
    if (surroundings_.pause.Until(other_hosts_by_) == Pause::End::kInterrupted) throw OutputClosed();
  }
}

std::vector<KnownChannel> Robot::Channels(bool own) const {
  AwaitOtherHosts();
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
  AwaitOtherHosts();
  // The other half of --timeout is left for what the command does then.
  const auto deadline = std::chrono::steady_clock::now() + options_.Timeout(2 * kAnswerTime) / 2;
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
      surroundings_.console.Say("Session " + Visible(SessionName(user.process, user.pid, user.host)) +
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
