#include "transport/zmq/publish/connection_watch.hpp"

#include <arpa/inet.h>
#include <linux/sockios.h>
#include <linux/tcp.h>  // The C library's tcp_info is older.
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr int kEventsPerTurn = 256;
constexpr std::uint64_t kGreetingBytes = 64;  // Of ZMTP 3: https://rfc.zeromq.org/spec/23
constexpr auto kLookAgainAfter = std::chrono::milliseconds(50);
constexpr int kStuckAfterLooks = 4;
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

bool HasGreeted(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return true;
  return size < offsetof(tcp_info, tcpi_bytes_received) + sizeof info.tcpi_bytes_received ||
         info.tcpi_bytes_received >= kGreetingBytes;
}

// Whether the other side has not read for so long that the send buffer is nearly full.
bool IsFull(int fd) {
  int waiting = 0;
  int buffer = 0;
  socklen_t size = sizeof buffer;
  if (ioctl(fd, SIOCOUTQ, &waiting) != 0 || getsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, &size) != 0) return false;
  return waiting >= buffer / 4;  // The system counts its own data structures as well.
}

}  // namespace

ConnectionWatch::ConnectionWatch(SharedState& shared, Socket& socket, const std::string& bound)
    : shared_(shared), socket_(socket), bound_(bound), monitor_(shared.context, ZMQ_PAIR), connections_(shared, bound) {
  socket_.Set(ZMQ_HANDSHAKE_IVL, kHandshakeMs);
  monitor_.Set(ZMQ_RCVHWM, 0);  // Otherwise ZeroMQ's thread would wait for us.
  const std::string monitored = "inproc://accepting-" + std::to_string(RandomId());
  constexpr int kEvents =
      ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_ACCEPT_FAILED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;
  if (zmq_socket_monitor(socket_.raw(), monitored.c_str(), kEvents) != 0 || monitor_.Connect(monitored) != 0) {
    throw Error(std::string("Cannot watch the connections of an endpoint: ") + zmq_strerror(zmq_errno()) + ".");
  }
}

ConnectionWatch::~ConnectionWatch() { Close(); }

void ConnectionWatch::Close() noexcept {
  if (monitor_.closed()) return;
  zmq_socket_monitor(socket_.raw(), nullptr, 0);
  monitor_.Close(0);
}

void ConnectionWatch::Tick() {
  (void)Update();
  connections_.CloseUseless(std::chrono::steady_clock::now());
  if (!listens_) {
    ListenAgain();
  } else {
    StopIfIpcIsInDanger();
  }
}

void ConnectionWatch::StopIfIpcIsInDanger() {
  if (bound_.starts_with("ipc:") && FreeDescriptors(kSpareDescriptors) < kSpareDescriptors) StopListening();
}

bool ConnectionWatch::Serve() { return input_.load() && input_.exchange(false) && Update(); }

bool ConnectionWatch::Update() {
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
        silent_.erase(value);
        plain_.erase(value);
        connections_.Remove(value);
        unfinished_.Remove(value);
        break;
      // ZeroMQ does not say of which connection, but reports the end of that one next.
      case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL: handshake_failure_ = value; break;
      case ZMQ_EVENT_ACCEPTED: OnAccepted(value); break;
      case ZMQ_EVENT_ACCEPT_FAILED:
        if (value == ENFILE || (value == EMFILE && FreeDescriptors(1) == 0)) StopListening();
        break;
      default: break;
    }
  }
  input_ = true;
  return true;
}

void ConnectionWatch::OnAccepted(int fd) {
  plain_.erase(fd);  // The earlier connection with this number.
  StopIfIpcIsInDanger();
  std::string address = AddressOf(fd);
  silent_.erase(fd);
  const auto now = std::chrono::steady_clock::now();
  if (!connections_.Add(fd, address, now) || address.empty()) return;
  unfinished_.Add(fd, now);
  std::erase_if(silent_, [](const auto& entry) { return HasGreeted(entry.first); });
  const auto count = std::ranges::count_if(silent_, [&](const auto& entry) { return entry.second == address; });
  if (static_cast<std::size_t>(count) < kMostSilent) {
    silent_.emplace(fd, std::move(address));
    return;
  }
  HangUp(fd, bound_);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq silent " + bound_,
                           "More than " + std::to_string(kMostSilent) + " connections from " + address + " to " +
                               bound_ + " say nothing: further ones are closed. Find the program that makes them.",
                           kSayAgainAfter);
}

// ZeroMQ's own faults are many. These two are what a client without the right key looks like.
void ConnectionWatch::OnHandshakeFailed(int fd, std::int32_t failure) {
  std::string_view why;
  const bool keys = shared_.options.security.has_value();
  if (failure == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) {
    why = keys ? "it has no keys; set `network.security` there, or do not let it connect"
               : "it encrypts, and this session has no keys; set `network.security` here, or remove it there";
  } else if (failure == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC && keys) {
    why = "it has another public key of ours than the right one; correct it in `network.security.servers` there";
  } else {
    return;
  }
  shared_.refused_handshakes.fetch_add(1, std::memory_order_relaxed);
  const std::string from = connections_.OriginOf(fd);
  shared_.log.WriteLimited(LogLevel::kWarning, "zmq keys " + bound_,
                           "A program on " + from + " cannot connect to " + bound_ + ": " + std::string(why) + ".",
                           kSayAgainAfter);
}

bool ConnectionWatch::CountTopic(int fd, std::string_view topic, bool subscribed) {
  (void)Update();  // The descriptor may be that of a new connection.
  return connections_.CountTopic(fd, topic, subscribed);
}

void ConnectionWatch::NotePlain(int fd) {
  if (fd >= 0) plain_.try_emplace(fd, 0);
}

void ConnectionWatch::NoteSession(int fd) {
  (void)Update();
  plain_.erase(fd);
  connections_.NoteSession(fd);
}

void ConnectionWatch::CutUnfinished() {
  for (const int fd : unfinished_.Look(std::chrono::steady_clock::now())) {
    connections_.Cut(fd, "unfinished",
                     "has sent more than " + std::to_string(UnfinishedMessages::kMostBytes >> 10) +
                         " KiB of a message that does not end: the connection is closed. Find the program.");
  }
}

void ConnectionWatch::CutStuckPlain(SteadyTime now) {
  if (now < next_look_) return;
  if (now > next_look_ + kLookAgainAfter) {  // The first look for a while.
    for (auto& [fd, full] : plain_) full = 0;
  }
  next_look_ = now + kLookAgainAfter;
  std::size_t with_room = 0;
  for (auto& [fd, full] : plain_) {
    full = IsFull(fd) ? full + 1 : 0;
    with_room += full == 0 ? 1 : 0;
  }
  if (with_room == 0) return;
  for (auto& [fd, full] : plain_) {
    if (full < kStuckAfterLooks) continue;
    HangUp(fd, bound_);
    full = 0;
    shared_.log.WriteLimited(LogLevel::kWarning, "zmq stuck " + bound_,
                             "A plain subscriber at " + bound_ +
                                 " does not read fast enough: its connection is closed, so that others get their "
                                 "messages. Let it read faster, or subscribe to less.");
  }
}

// ZeroMQ's thread would try again and again to accept the connections that wait. The system ends them; their programs
// connect again later.
void ConnectionWatch::StopListening() {
  if (!listens_) return;
  listens_ = false;
  zmq_unbind(socket_.raw(), bound_.c_str());
  shared_.log.WriteLimited(
      LogLevel::kWarning, "zmq accept " + bound_,
      "Another program cannot connect to " + bound_ + ": the limit of open files is reached. Raise it (ulimit -n).",
      kSayAgainAfter);
}

void ConnectionWatch::ListenAgain() {
  // Twice as many, so that it does not stop again at once.
  if (FreeDescriptors(2 * kSpareDescriptors) < 2 * kSpareDescriptors) return;
  try {
    BindOrThrow(socket_, bound_);
    listens_ = true;
  } catch (const Error& error) {
    shared_.log.WriteLimited(LogLevel::kError, "zmq listen " + bound_,
                             std::string("Other programs still cannot connect. ") + error.what(), kSayAgainAfter);
  }
}

}  // namespace hgros::zmq
