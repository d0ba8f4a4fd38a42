#include "transport/zmq/endpoint.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <thread>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kMaxPathBytes = sizeof(sockaddr_un::sun_path) - 1;

/// Whether a process uses the unix socket, of any kind. '@' stands for the abstract namespace.
bool IsListening(std::string_view path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  if (path.front() == '@') address.sun_path[0] = '\0';
  const auto size =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + (path.front() == '@' ? 0 : 1));
  const int rc = connect(fd, reinterpret_cast<const sockaddr*>(&address), size);
  // A full backlog means that a process listens, even if slowly; another protocol, that it is a socket of another kind.
  const bool listens = rc == 0 || errno == EAGAIN || errno == EINPROGRESS || errno == EPROTOTYPE;
  close(fd);
  return listens;
}

/// Whether there is something that is not a socket. ZeroMQ would remove it.
bool IsTakenByFile(const std::string& path) {
  struct stat status {};
  return path.front() != '@' && lstat(path.c_str(), &status) == 0 && !S_ISSOCK(status.st_mode);
}

/// Throws Error if the file of an ipc endpoint may not be replaced.
void RequireFreePath(const std::string& endpoint) {
  const std::string path = endpoint.substr(kIpc.size());
  if (IsListening(path)) {
    throw Error("Cannot publish at " + endpoint + ": another program listens there.", {},
                "End the other program, or choose another path.");
  }
  if (IsTakenByFile(path)) {
    throw Error("Cannot publish at " + endpoint + ": there is a file that is not a socket.", {},
                "Choose another path, or remove the file.");
  }
}

std::string HiddenPath(std::string_view bound) { return std::string(bound.substr(kIpc.size())) + ".paused"; }

// Takes the connections that wait, and closes them. Runs on a thread with a copy of the descriptors of its own, so that
// it may close one there; other threads keep theirs, and cannot take it. True if none waits any more.
bool TurnAway(int listening) noexcept {
  constexpr int kMost = 1 << 20;
  if (unshare(CLONE_FILES) != 0) return false;
  for (int fd = 0; fd < kMost && (fd == listening || close(fd) != 0); ++fd) {
  }
  for (int i = 0; i < kMost; ++i) {
    const int fd = accept4(listening, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd >= 0) {
      close(fd);
    } else if (errno != ECONNABORTED && errno != EPROTO) {
      return errno == EAGAIN;
    }
  }
  return false;
}

std::string BindRemedy(int error, bool ipc) {
  switch (error) {
    case EADDRINUSE:
      return "Another program uses the port: end it, or choose another port; \"tcp://127.0.0.1:*\" takes a free one.";
    case EACCES:
      return ipc ? "Choose a folder this user may write to." : "Ports below 1024 need privileges: choose a higher one.";
    case ENOENT: return "Create the folder of the ipc path first.";
    case ENODEV:
    case EADDRNOTAVAIL: return "The address is not one of this machine's: use one of them, or tcp://*:port for all.";
    case EINVAL: return "Write it as tcp://address:port or ipc:///path.";
    default: return {};
  }
}

}  // namespace

std::string FullEndpoint(std::string_view endpoint) {
  const std::string full =
      endpoint.find("://") == std::string_view::npos ? std::string(kTcp).append(endpoint) : std::string(endpoint);
  if (full.starts_with(kIpc)) {
    const std::size_t path_bytes = full.size() - kIpc.size();
    if (path_bytes == 0) throw Error("The endpoint " + full + " has no path.", {}, "Write it as ipc:///path.");
    if (path_bytes > kMaxPathBytes) {
      throw Error("The path of the endpoint " + full + " has " + std::to_string(path_bytes) +
                      " bytes; a unix socket's may have " + std::to_string(kMaxPathBytes) + ".",
                  {}, "Choose a shorter path.");
    }
  } else if (!full.starts_with(kTcp) || full.size() == kTcp.size()) {
    throw Error("The endpoint " + full + " cannot be used.", {}, "Write it as tcp://address:port or ipc:///path.");
  }
  return full;
}

void SetFamily(Socket& socket, const std::string& endpoint) {
  socket.Set(ZMQ_IPV6, endpoint.starts_with(std::string(kTcp) + '[') ? 1 : 0);
}

void BindOrThrow(Socket& socket, const std::string& endpoint) {
  RequireDescriptors(kSpareDescriptors, "Cannot publish at " + endpoint);
  const bool ipc = endpoint.starts_with(kIpc);
  if (ipc && endpoint != "ipc://*") RequireFreePath(endpoint);
  const int error = socket.Bind(endpoint);
  if (error != 0) {
    throw Error("Cannot publish at " + endpoint + ": " + zmq_strerror(error) + ".", {}, BindRemedy(error, ipc));
  }
}

std::string HostNameOf(std::string_view endpoint) {
  if (!endpoint.starts_with(kTcp)) return {};
  endpoint.remove_prefix(kTcp.size());
  std::string host(endpoint.substr(0, endpoint.rfind(':')));
  in_addr address{};
  const bool is_name = !host.empty() && host.front() != '[' && host.find_first_of(":*;") == std::string::npos &&
                       inet_pton(AF_INET, host.c_str(), &address) != 1;
  return is_name ? host : std::string();
}

std::string ResolveFault(const std::string& host) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &wanted, &found);
  if (error != 0) return gai_strerror(error);
  freeaddrinfo(found);
  return {};
}

void CloseListening(Context& context, Socket& socket, int linger_ms) noexcept {
  // ZeroMQ closes the listening socket on its own thread, and reports that on a monitor. zmq_unbind() would end the
  // connections, too, without sending what waits for them.
  void* monitor = zmq_socket(context.raw(), ZMQ_PAIR);
  const std::string monitored = "inproc://closing-" + std::to_string(RandomId());
  const bool reports =
      monitor != nullptr &&
      zmq_socket_monitor(socket.raw(), monitored.c_str(), ZMQ_EVENT_CLOSED | ZMQ_EVENT_CLOSE_FAILED) == 0 &&
      zmq_connect(monitor, monitored.c_str()) == 0;
  if (!reports) zmq_socket_monitor(socket.raw(), nullptr, 0);
  socket.Close(linger_ms);
  // Without a limit: a report that nobody could get would block ZeroMQ's thread.
  zmq_pollitem_t item{monitor, 0, ZMQ_POLLIN, 0};
  while (reports && zmq_poll(&item, 1, -1) < 0 && zmq_errno() == EINTR) {
  }
  if (monitor != nullptr) zmq_close(monitor);
}

bool HidePath(const std::string& bound) {
  if (!bound.starts_with(kIpc) || bound[kIpc.size()] == '@') return false;
  const std::string hidden = HiddenPath(bound);
  // Without its file the socket cannot be reached anyway.
  return !IsTakenByFile(hidden) && (std::rename(bound.c_str() + kIpc.size(), hidden.c_str()) == 0 || errno == ENOENT);
}

void ShowPath(const std::string& bound) {
  RequireFreePath(bound);
  if (std::rename(HiddenPath(bound).c_str(), bound.c_str() + kIpc.size()) == 0 || errno == ENOENT) return;
  throw Error("Cannot publish at " + bound + ": " + std::strerror(errno) + ".", {},
              "Let this user write to the folder.");
}

bool TurnAwayWaiting(int listening) noexcept {
  if (fcntl(listening, F_SETFL, fcntl(listening, F_GETFL) | O_NONBLOCK) != 0) return false;
  bool done = false;
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // A handler of the program would run with other descriptors.
  try {
    StartThread<std::thread>("the thread that turns connections away", [&done, listening] {
      done = TurnAway(listening);
    }).join();
  } catch (const std::exception&) {  // There is no thread, either.
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return done;
}

}  // namespace hgros::zmq
