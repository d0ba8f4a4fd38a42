#include "transport/shm/pair/pair_socket.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

namespace hgros::shm {
namespace {

constexpr std::size_t kHeaderBytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t kMaxHandles = 4;        // In one frame.
constexpr std::size_t kMaxStrayHandles = 64;  // Received before their frames.
constexpr std::size_t kReadBytes = 64 * 1024;
constexpr int kReadsAtOnce = 2;  // The caller has other sockets to read.

bool AddressOf(const std::string& place, sockaddr_un& address, socklen_t& size, std::string& fault) {
  address = {};
  address.sun_family = AF_UNIX;
  if (place.empty() || place.size() >= sizeof address.sun_path) {
    fault = "the name of the socket is empty or too long";
    return false;
  }
  // The first byte stays zero: the name is in the abstract namespace.
  std::memcpy(address.sun_path + 1, place.data(), place.size());
  size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + place.size());
  return true;
}

Handle MakeSocket(std::string& fault) {
  Handle made(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made.valid()) fault = std::string("no socket can be made: ") + std::strerror(errno);
  return made;
}

}  // namespace

uid_t PairSocket::PeerUser() const noexcept {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (getsockopt(socket_->fd(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return static_cast<uid_t>(-1);
  return credentials.uid;
}

pid_t PairSocket::PeerProcess() const noexcept {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (getsockopt(socket_->fd(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return 0;
  return credentials.pid;
}

void PairSocket::Send(const wire::PairMessage& message, const Handles& handles) {
  Piece piece;
  piece.bytes.resize(kHeaderBytes);
  message.AppendToString(&piece.bytes);
  const auto length = static_cast<std::uint32_t>(piece.bytes.size() - kHeaderBytes);
  const auto count = static_cast<std::uint32_t>(handles.size());
  std::memcpy(piece.bytes.data(), &length, sizeof length);
  std::memcpy(piece.bytes.data() + sizeof length, &count, sizeof count);
  piece.handles = handles;
  const std::scoped_lock lock(send_mutex_);
  if (broken_) return;
  outgoing_.push_back(std::move(piece));
  if (outgoing_.size() == 1) SendQueued();
}

void PairSocket::Flush() noexcept {
  const std::scoped_lock lock(send_mutex_);
  SendQueued();
}

void PairSocket::SendQueued() noexcept {
  while (!outgoing_.empty()) {
    Piece& piece = outgoing_.front();
    iovec part{piece.bytes.data() + piece.sent, piece.bytes.size() - piece.sent};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(kMaxHandles * sizeof(int))> control{};
    if (piece.sent == 0 && !piece.handles.empty()) {
      const std::size_t bytes = piece.handles.size() * sizeof(int);
      header.msg_control = control.data();
      header.msg_controllen = CMSG_SPACE(bytes);
      cmsghdr* rights = CMSG_FIRSTHDR(&header);
      rights->cmsg_level = SOL_SOCKET;
      rights->cmsg_type = SCM_RIGHTS;
      rights->cmsg_len = CMSG_LEN(bytes);
      for (std::size_t i = 0; i < piece.handles.size(); ++i) {
        const int fd = piece.handles[i]->fd();
        std::memcpy(CMSG_DATA(rights) + i * sizeof fd, &fd, sizeof fd);
      }
    }
    const auto sent = sendmsg(socket_->fd(), &header, MSG_NOSIGNAL);
    if (sent < 0) {
      if (errno == EINTR) continue;
      // Any other error may be temporary, such as too many descriptors in flight to stopped sessions.
      if (errno != EPIPE && errno != ECONNRESET) return;
      // The other side has gone. Receive() reports that.
      broken_ = true;
      outgoing_.clear();
      return;
    }
    piece.sent += static_cast<std::size_t>(sent);
    if (piece.sent == piece.bytes.size()) outgoing_.pop_front();
  }
}

PairSocket::Read PairSocket::Fail(std::string what) {
  fault_ = std::move(what);
  return Read::kFault;
}

PairSocket::Read PairSocket::ReadMore() {
  if (parsed_ > 0) {
    incoming_.erase(0, parsed_);
    parsed_ = 0;
  }
  const std::size_t before = incoming_.size();
  incoming_.resize(before + kReadBytes);
  iovec part{incoming_.data() + before, kReadBytes};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(kMaxHandles * sizeof(int))> control{};
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  const auto got = recvmsg(socket_->fd(), &header, MSG_CMSG_CLOEXEC);
  const int error = errno;
  incoming_.resize(before + (got > 0 ? static_cast<std::size_t>(got) : 0));
  if (got < 0) {
    if (error == EINTR) return Read::kFrame;  // Read again.
    if (error == EAGAIN || error == EWOULDBLOCK) return Read::kNothing;
    closed_ = true;
    return Read::kClosed;
  }
  received_bytes_ += static_cast<std::uint64_t>(got);
  for (cmsghdr* rights = CMSG_FIRSTHDR(&header); rights != nullptr; rights = CMSG_NXTHDR(&header, rights)) {
    if (rights->cmsg_level != SOL_SOCKET || rights->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (rights->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(rights) + i * sizeof fd, sizeof fd);
      handles_.emplace_back(fd);
    }
  }
  if (got == 0) {
    closed_ = true;
    return Read::kClosed;
  }
  if ((header.msg_flags & MSG_CTRUNC) != 0) return Fail("descriptors were lost: the limit of open files is reached");
  if (handles_.size() > kMaxStrayHandles) return Fail("it sends descriptors without their frames");
  return Read::kFrame;
}

PairSocket::Read PairSocket::ThrowAway() {
  for (int i = 0; i < kReadsAtOnce; ++i) {
    incoming_.clear();
    parsed_ = 0;
    handles_.clear();
    if (closed_) return Read::kClosed;
    if (ReadMore() == Read::kNothing) return Read::kNothing;
  }
  return Read::kFault;
}

PairSocket::Read PairSocket::Receive(Frame& frame) {
  if (!fault_.empty()) return ThrowAway();
  for (int reads = 0;; ++reads) {
    const std::size_t available = incoming_.size() - parsed_;
    if (available >= kHeaderBytes) {
      std::uint32_t length = 0;
      std::uint32_t count = 0;
      std::memcpy(&length, incoming_.data() + parsed_, sizeof length);
      std::memcpy(&count, incoming_.data() + parsed_ + sizeof length, sizeof count);
      if (length > max_frame_bytes_) return Fail("it sends a frame of " + std::to_string(length) + " bytes");
      if (count > kMaxHandles) return Fail("it sends too many descriptors at once");
      if (available >= kHeaderBytes + length) {
        if (handles_.size() < count) return Fail("a frame comes without its descriptors");
        frame.handles.clear();
        for (; count > 0; --count) {
          frame.handles.push_back(std::move(handles_.front()));
          handles_.pop_front();
        }
        const bool parsed =
            frame.message.ParseFromArray(incoming_.data() + parsed_ + kHeaderBytes, static_cast<int>(length));
        parsed_ += kHeaderBytes + length;
        if (!parsed) return Fail("it sends a frame that does not parse");
        return Read::kFrame;
      }
    }
    if (closed_) return Read::kClosed;
    if (reads == kReadsAtOnce) return Read::kMore;
    if (const Read read = ReadMore(); read != Read::kFrame) {
      if (read != Read::kClosed) return read;
    }
  }
}

Handle WatchProcess(pid_t pid) noexcept {
  constexpr long kPidfdOpen = 434;  // The same number on all architectures; older headers do not have it.
  return pid > 0 ? Handle(static_cast<int>(syscall(kPidfdOpen, pid, 0))) : Handle();
}

bool HasEnded(const Handle& process) noexcept {
  pollfd ask{process.fd(), POLLIN, 0};
  return process.valid() && poll(&ask, 1, 0) > 0 && (ask.revents & POLLIN) != 0;
}

Handle ListenAt(const std::string& place, std::string& fault) {
  sockaddr_un address;
  socklen_t size = 0;
  if (!AddressOf(place, address, size, fault)) return {};
  Handle made = MakeSocket(fault);
  if (!made.valid()) return {};
  if (bind(made.fd(), reinterpret_cast<const sockaddr*>(&address), size) != 0 || listen(made.fd(), SOMAXCONN) != 0) {
    fault = std::string("it cannot listen at \"") + place + "\": " + std::strerror(errno);
    return {};
  }
  return made;
}

Handle AcceptFrom(const Handle& listening, bool& out_of_descriptors) noexcept {
  Handle made(accept4(listening.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  out_of_descriptors = !made.valid() && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM);
  return made;
}

Handle ConnectTo(const std::string& place, std::string& fault) {
  sockaddr_un address;
  socklen_t size = 0;
  if (!AddressOf(place, address, size, fault)) return {};
  Handle made = MakeSocket(fault);
  if (!made.valid()) return {};
  if (connect(made.fd(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    fault = std::string("nobody listens at \"") + place + "\": " + std::strerror(errno);
    return {};
  }
  return made;
}

}  // namespace hgros::shm
