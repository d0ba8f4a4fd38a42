#include "transport/zmq/connection.hpp"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/sockios.h>
#include <linux/tcp.h>  // The C library's tcp_info is older.
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

// Of a TCP header: https://www.rfc-editor.org/rfc/rfc9293#section-3.1
constexpr std::uint32_t kFlagsAt = 13;
constexpr std::uint32_t kReset = 4;
// States of the kernel, as ss(8) calls them: CLOSE and CLOSE-WAIT.
constexpr int kClosed = 7;
constexpr int kClosedByPeer = 8;
constexpr std::uint32_t kNoAnswerMs = 3'500;  // To a question of the kernel.

// None if the kernel does not count bytes (before 4.1), or it is no tcp connection.
std::optional<tcp_info> TcpInfo(int fd) noexcept {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return {};
  if (size < offsetof(tcp_info, tcpi_bytes_received) + sizeof info.tcpi_bytes_received) return {};
  return info;
}

/// Whether the socket is a connection that was accepted at the endpoint.
bool WasAcceptedAt(int fd, std::string_view bound) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  sockaddr_storage other{};
  socklen_t other_size = sizeof other;
  if (getpeername(fd, reinterpret_cast<sockaddr*>(&other), &other_size) != 0) return false;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size) != 0) return false;
  if (name.ss_family == AF_UNIX) {
    const std::size_t offset = offsetof(sockaddr_un, sun_path);
    if (size <= offset || !bound.starts_with(kIpc)) return false;
    std::string path(reinterpret_cast<const sockaddr_un*>(&name)->sun_path, size - offset);
    if (path.front() == '\0') path.front() = '@';
    return path.substr(0, path.find('\0')) == bound.substr(kIpc.size());
  }
  std::uint16_t port = 0;
  if (name.ss_family == AF_INET) port = ntohs(reinterpret_cast<const sockaddr_in*>(&name)->sin_port);
  if (name.ss_family == AF_INET6) port = ntohs(reinterpret_cast<const sockaddr_in6*>(&name)->sin6_port);
  return port != 0 && bound.starts_with(kTcp) && bound.ends_with(":" + std::to_string(port));
}

/// Calls `use(fd, own)` with the connection that has ZeroMQ's descriptor `named`, if it is one to the endpoint.
// ZeroMQ's thread may have closed the descriptor, and another file may have its number by now. So we check and use a
// reference of our own. In the worst case this is another connection to the endpoint, which will be made again.
template <class Use>
void WithConnection(int named, std::string_view bound, Use&& use) noexcept {
  if (named < 0) return;
  const int own = fcntl(named, F_DUPFD_CLOEXEC, 0);
  const int fd = own >= 0 ? own : named;  // There may be no descriptor left.
  if (WasAcceptedAt(fd, bound)) use(fd, own >= 0);
  if (own >= 0) close(own);
}

/// Lets the kernel run the filter for each segment of the tcp socket. The filter returns how many bytes to keep, from
/// the TCP header on. With 0 the segment is dropped. False if that is impossible.
template <std::size_t kSize>
bool SetFilter(int fd, std::array<sock_filter, kSize>& code) noexcept {
  int protocol = 0;
  socklen_t size = sizeof protocol;
  if (getsockopt(fd, SOL_SOCKET, SO_PROTOCOL, &protocol, &size) != 0 || protocol != IPPROTO_TCP) return false;
  const sock_fprog filter{kSize, code.data()};
  return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0;
}

bool DropResets(int fd) noexcept {
  std::array<sock_filter, 4> code{{
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kFlagsAt),
      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, kReset, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, 0),
      BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
  }};
  return SetFilter(fd, code);
}

// The kernel would send the end of a connection again and again, for minutes, if it drops the reset that answers.
// Meanwhile nobody can connect from the same port.
void SetForgotten(int fd, bool forgotten) noexcept {
  const linger value{forgotten ? 1 : 0, 0};
  setsockopt(fd, SOL_SOCKET, SO_LINGER, &value, sizeof value);
}

}  // namespace

void IgnoreResets(int listening) noexcept {
  if (DropResets(listening)) SetForgotten(listening, true);
}

void SetIgnoresResets(int named, std::string_view bound, bool ignores) noexcept {
  WithConnection(named, bound, [&](int fd, bool /*own*/) {
    pollfd end{fd, POLLRDHUP, 0};
    if (poll(&end, 1, 0) != 0) return;  // It was closed, here or there.
    constexpr int kUnused = 0;          // But the system wants a value.
    if (!ignores || !DropResets(fd)) setsockopt(fd, SOL_SOCKET, SO_DETACH_FILTER, &kUnused, sizeof kUnused);
  });
}

void KeepWhenClosed(int named, std::string_view bound) noexcept {
  WithConnection(named, bound, [](int fd, bool /*own*/) { SetForgotten(fd, false); });
}

std::optional<Progress> ProgressOf(int fd, bool asks_unread) noexcept {
  const auto info = TcpInfo(fd);
  if (!info) return {};
  const bool waits = info->tcpi_unacked > 0 || info->tcpi_notsent_bytes > 0;
  const bool ended = info->tcpi_state == kClosed || info->tcpi_state == kClosedByPeer;
  const auto read = ended || asks_unread ? BytesRead(fd) : std::nullopt;
  return Progress{.acknowledged = info->tcpi_bytes_acked,
                  .waits = waits,
                  .read = read.value_or(0),
                  .ended = ended,
                  .unread = asks_unread && read && *read < info->tcpi_bytes_received,
                  .unanswered = waits ? info->tcpi_retransmits > 1 || info->tcpi_probes > 1
                                      : std::min(info->tcpi_last_ack_recv, info->tcpi_last_data_recv) > kNoAnswerMs};
}

std::optional<std::uint64_t> BytesReceived(int fd) noexcept {
  const auto info = TcpInfo(fd);
  return info ? std::optional(info->tcpi_bytes_received) : std::nullopt;
}

std::optional<std::uint64_t> BytesAcknowledged(int fd) noexcept {
  const auto info = TcpInfo(fd);
  return info ? std::optional(info->tcpi_bytes_acked) : std::nullopt;
}

std::optional<std::uint64_t> BytesRead(int fd) noexcept {
  // In this order: what comes between the two calls makes the result smaller.
  const auto received = BytesReceived(fd);
  int waiting = 0;
  if (!received || ioctl(fd, SIOCINQ, &waiting) != 0) return {};
  const auto left = static_cast<std::uint64_t>(waiting);
  return *received > left ? *received - left : 0;
}

void HangUp(Message& frame, std::string_view bound) noexcept { HangUp(zmq_msg_get(frame.raw(), ZMQ_SRCFD), bound); }

// With an error, or both directions shut down, a connection that waits would end the process if a PING is left in it
// (docs/decisions/0050). So nothing more comes in, and ZeroMQ finds the end of what has come.
void HangUp(int named, std::string_view bound) noexcept {
  WithConnection(named, bound, [](int fd, bool own) {
    std::array<sock_filter, 1> nothing{{BPF_STMT(BPF_RET | BPF_K, 0)}};
    if (SetFilter(fd, nothing)) {
      shutdown(fd, SHUT_RD);
      SetForgotten(fd, true);
    } else {
      shutdown(fd, SHUT_RDWR);
    }
    // ZeroMQ would still read and keep what has arrived. Without a reference of our own that might be another's.
    std::array<char, 16384> unread;
    while (own && recv(fd, unread.data(), unread.size(), MSG_DONTWAIT) > 0) {
    }
  });
}

}  // namespace hgros::zmq
