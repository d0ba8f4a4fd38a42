#include "transport/zmq/publish/connection_watch.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"
#include "transport/zmq/connection.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr int kEventsPerTurn = 256;
constexpr int kMostTurns = 64;
constexpr auto kClosedFor = std::chrono::seconds(10);  // Other processes may free descriptors meanwhile.
constexpr auto kSayAgainAfter = std::chrono::hours(1);

// The address of the other side, without its port; empty if it is not an IP connection.
std::string AddressOf(int fd) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  if (getpeername(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0) return {};
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* address = nullptr;
  if (name.ss_family == AF_INET) address = &reinterpret_cast<const sockaddr_in*>(&name)->sin_addr;
  if (name.ss_family == AF_INET6) address = &reinterpret_cast<const sockaddr_in6*>(&name)->sin6_addr;
  if (address == nullptr || inet_ntop(name.ss_family, address, text.data(), text.size()) == nullptr) return {};
  return text.data();
}

}  // namespace

ConnectionWatch::ConnectionWatch(SharedState& shared, Socket& socket, const std::string& bound)
    : shared_(shared), socket_(socket), bound_(bound), monitor_(shared.context, ZMQ_PAIR), connections_(shared, bound) {
  socket_.Set(ZMQ_HANDSHAKE_IVL, kHandshakeMs);
  monitor_.Set(ZMQ_RCVHWM, 0);  // Otherwise ZeroMQ's thread would wait for us.
  const std::string monitored = "inproc://accepting-" + std::to_string(RandomId());
  constexpr int kEvents = ZMQ_EVENT_LISTENING | ZMQ_EVENT_CLOSED | ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_ACCEPT_FAILED |
                          ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;
  if (zmq_socket_monitor(socket_.raw(), monitored.c_str(), kEvents) != 0 || monitor_.Connect(monitored) != 0) {
    throw Error(std::string("Cannot watch the connections of an endpoint: ") + zmq_strerror(zmq_errno()) + ".");
  }
}

ConnectionWatch::~ConnectionWatch() { Close(); }

void ConnectionWatch::Close() noexcept {
  if (monitor_.closed()) return;
  zmq_socket_monitor(socket_.raw(), nullptr, 0);
  monitor_.Close(0);
  unfinished_.Close();
  if (std::exchange(listening_, Listening::kOpen) != Listening::kHidden) return;
  try {
    ShowPath(bound_);  // ZeroMQ may want to remove the file.
  } catch (const Error&) {
    // Another program listens there now.
  }
}

void ConnectionWatch::Tick() {
  (void)Update();
  const auto now = std::chrono::steady_clock::now();
  connections_.CloseIdle(now);
  const bool left_alone = connections_.CloseDead(now);
  if (listening_ != Listening::kOpen) {
    ListenAgain(now);
  } else if (left_alone) {
    // With keys, libzmq 4.3.4 may keep a connection over which wrong bytes came, with all that is sent to it.
    closed_until_ = now;
    Unbind("because ZeroMQ does not end one of them. They can connect again in a moment.");
  } else {
    StopIfIpcIsInDanger();
  }
}

void ConnectionWatch::StopIfIpcIsInDanger() {
  if (listening_ != Listening::kOpen || !bound_.starts_with("ipc:")) return;
  if (FreeDescriptors(kSpareDescriptors) >= kSpareDescriptors) return;
  // The same text each time, so that it is said once.
  const std::string why = "because fewer than " + std::to_string(kSpareDescriptors) +
                          " more files can be opened. Raise the limit of open files (ulimit -n).";
  if (!HidePath(bound_)) {
    Unbind(why);
    return;
  }
  listening_ = Listening::kHidden;
  (void)TurnAwayWaiting(listening_fd_);
  Warn("Other programs cannot connect to " + bound_ + " for now, " + why);
}

bool ConnectionWatch::Serve() { return input_.load() && input_.exchange(false) && Update(); }

bool ConnectionWatch::Update() {
  std::int32_t accept_failure = 0;
  const bool more = ReadEvents(accept_failure);
  if (accept_failure != 0) OnAcceptFailed(accept_failure);
  return more;
}

// The connections of the messages that are read next must be known.
void ConnectionWatch::UpdateAll() {
  for (int i = 0; i < kMostTurns && Update(); ++i) {
  }
}

bool ConnectionWatch::ReadEvents(std::int32_t& accept_failure) {
  Message event;
  Message address;
  for (int i = 0; i < kEventsPerTurn; ++i) {
    if (!monitor_.Receive(event)) return false;
    if (event.more()) monitor_.Receive(address);
    std::uint16_t what = 0;
    std::int32_t value = 0;
    if (event.bytes().size() < sizeof what + sizeof value) continue;
    std::memcpy(&what, event.bytes().data(), sizeof what);
    std::memcpy(&value, event.bytes().data() + sizeof what, sizeof value);
    switch (what) {
      case ZMQ_EVENT_DISCONNECTED:
        if (const auto failure = std::exchange(handshake_failure_, 0)) OnHandshakeFailed(value, failure);
        connections_.Remove(value);
        unfinished_.Remove(value);
        break;
      // ZeroMQ does not say of which connection, but reports the end of that one next.
      case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL: handshake_failure_ = value; break;
      case ZMQ_EVENT_ACCEPTED: OnAccepted(value); break;
      case ZMQ_EVENT_ACCEPT_FAILED:
        if (value == EMFILE || value == ENFILE) accept_failure = value;
        break;
      case ZMQ_EVENT_LISTENING:
        listening_fd_ = value;
        IgnoreResets(value);
        break;
      case ZMQ_EVENT_CLOSED:  // With all connections: their ends are not reported.
        listening_fd_ = -1;
        connections_.Clear();
        unfinished_.Clear();
        break;
      default: break;
    }
  }
  input_ = true;
  return true;
}

void ConnectionWatch::OnAccepted(int fd) {
  StopIfIpcIsInDanger();
  const std::string address = AddressOf(fd);
  const auto now = std::chrono::steady_clock::now();
  if (!connections_.Add(fd, address, now) || address.empty()) return;
  SetIgnoresResets(fd, bound_, true);  // It may have come before its endpoint did.
  unfinished_.Add(fd, now);
}

// ZeroMQ's own faults are many. These two are what a client without the right key looks like.
void ConnectionWatch::OnHandshakeFailed(int fd, std::int32_t failure) {
  std::string_view why;
  const bool keys = shared_.options.security.has_value();
  if (failure == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) {
    why = keys ? "it has no keys; set `network.security` there, or do not let it connect"
               : "it encrypts, and this session has no keys; set `network.security` here, or remove it there";
  } else if (failure == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC && keys) {
    why = "it has a wrong public key for this session; correct it in `network.security.servers` there";
  } else {
    return;
  }
  shared_.refused_handshakes.fetch_add(1, std::memory_order_relaxed);
  // The address may be known for one connection of a program and not for its next: lines of both kinds are limited.
  const std::string from = connections_.OriginOf(fd);
  shared_.log.WriteLimited(LogLevel::kWarning, (connections_.HasAddress(fd) ? "zmq keys " : "zmq keys, gone ") + bound_,
                           "A program on " + from + " cannot connect to " + bound_ + ": " + std::string(why) + ".",
                           kSayAgainAfter);
}

bool ConnectionWatch::CountTopic(int fd, std::string_view topic, bool subscribed) {
  UpdateAll();
  return connections_.CountTopic(fd, topic, subscribed);
}

bool ConnectionWatch::NoteSession(int fd, SessionId session) {
  UpdateAll();
  return connections_.NoteSession(fd, session);
}

bool ConnectionWatch::MaySpeakFor(int fd, SessionId session, std::uint64_t proof) {
  UpdateAll();
  return connections_.MaySpeakFor(fd, session, proof);
}

void ConnectionWatch::CutUnfinished() {
  for (const int fd : unfinished_.Look(std::chrono::steady_clock::now())) {
    connections_.Cut(fd, "unfinished",
                     "has sent more than " + std::to_string(UnfinishedMessages::kMostBytes >> 10) +
                         " KiB of a message that does not end: the connection is closed. Find the program.");
  }
}

// ZeroMQ's thread would try again and again to accept the connections that wait.
void ConnectionWatch::OnAcceptFailed(std::int32_t error) {
  if (listening_ == Listening::kClosed) return;
  const bool own = error == EMFILE;
  if (TurnAwayWaiting(listening_fd_) || bound_.starts_with("ipc:")) {
    Warn("Another program cannot connect to " + bound_ +
         (own ? ": the limit of open files is reached. Raise it (ulimit -n)."
              : ": the system's limit of open files is reached. Raise it (sysctl fs.file-max)."));
    return;
  }
  closed_until_ = std::chrono::steady_clock::now() + kClosedFor;
  Unbind(own ? "because the limit of open files is reached. Raise it (ulimit -n)."
             : "because the system's limit of open files is reached. Raise it (sysctl fs.file-max).");
}

void ConnectionWatch::Unbind(const std::string& why) {
  listening_ = Listening::kClosed;
  zmq_unbind(socket_.raw(), bound_.c_str());
  Warn(bound_ + " stops listening, and its connections are closed, " + why);
}

void ConnectionWatch::Warn(const std::string& text) {
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq accept " + bound_, text, kSayAgainAfter);
}

void ConnectionWatch::ListenAgain(SteadyTime now) {
  // Twice as many, so that it does not stop again at once.
  if (now < closed_until_ || FreeDescriptors(2 * kSpareDescriptors) < 2 * kSpareDescriptors) return;
  try {
    if (listening_ == Listening::kHidden) {
      ShowPath(bound_);
    } else {
      BindOrThrow(socket_, bound_);
    }
    listening_ = Listening::kOpen;
  } catch (const Error& error) {
    shared_.log.WriteLimited(LogLevel::kError, "zmq listen " + bound_,
                             std::string("Other programs still cannot connect. ") + error.what(), kSayAgainAfter);
  }
}

}  // namespace hgros::zmq
