#include "transport/shm/pair/pair_socket.hpp"

#include <fcntl.h>
#include <google/protobuf/io/coded_stream.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <utility>

namespace hgros::shm {
namespace {

constexpr std::size_t kHeaderBytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t kMaxHandles = 4;     // In one frame.
constexpr std::size_t kMaxStraySets = 16;  // Received before their frames.
constexpr std::size_t kReadBytes = 64 * 1024;
constexpr int kReadsAtOnce = 2;  // The caller has other sockets to read.
constexpr std::size_t kLargeReadBytes = 1024 * 1024;
constexpr suseconds_t kWaitForRoomUs = 20'000;
constexpr std::size_t kSendBytes = 4 * 1024 * 1024;

// The tags of a payload in a frame (proto/hgros/pair.proto), whose fields are written in this order.
constexpr std::uint32_t kPayloadTag = wire::PairMessage::kPayloadFieldNumber << 3 | 2;
constexpr std::uint32_t kLinkTag = wire::PayloadApart::kLinkFieldNumber << 3 | 1;
constexpr std::uint32_t kNumberTag = wire::PayloadApart::kNumberFieldNumber << 3 | 1;
constexpr std::uint32_t kDataTag = wire::PayloadApart::kDataFieldNumber << 3 | 2;
constexpr std::size_t kMostPrefixBytes = 32;  // Everything in the frame before the data.

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
  if (outgoing_.size() == 1) (void)SendQueued(std::numeric_limits<std::size_t>::max());
}

void PairSocket::SendPayload(std::uint64_t link, std::uint64_t number, Payload data) {
  using google::protobuf::io::CodedOutputStream;
  const auto size = static_cast<std::uint32_t>(data.bytes.size());
  const std::size_t inner = 2 * (1 + sizeof(std::uint64_t)) + 1 + CodedOutputStream::VarintSize32(size) + size;
  std::string bytes(kHeaderBytes + kMostPrefixBytes, '\0');
  auto* const begin = reinterpret_cast<std::uint8_t*>(bytes.data());
  auto* at = CodedOutputStream::WriteTagToArray(kPayloadTag, begin + kHeaderBytes);
  at = CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(inner), at);
  at = CodedOutputStream::WriteTagToArray(kLinkTag, at);
  at = CodedOutputStream::WriteLittleEndian64ToArray(link, at);
  at = CodedOutputStream::WriteTagToArray(kNumberTag, at);
  at = CodedOutputStream::WriteLittleEndian64ToArray(number, at);
  at = CodedOutputStream::WriteTagToArray(kDataTag, at);
  at = CodedOutputStream::WriteVarint32ToArray(size, at);
  bytes.resize(static_cast<std::size_t>(at - begin));
  const auto length = static_cast<std::uint32_t>(bytes.size() - kHeaderBytes + size);
  std::memcpy(bytes.data(), &length, sizeof length);
  const std::scoped_lock lock(send_mutex_);
  if (broken_) {
    spent_.push_back(std::move(data));
  } else {
    outgoing_.push_back({.bytes = std::move(bytes), .payload = std::move(data), .sent = 0, .handles = {}});
    if (outgoing_.size() == 1) (void)SendQueued(kReadBytes);
  }
}

bool PairSocket::Flush() {
  std::vector<Payload> spent;  // Destroyed after the lock.
  const std::scoped_lock lock(send_mutex_);
  const bool more = SendQueued(kSendBytes);
  spent.swap(spent_);
  return more;
}

// True if it stops because of the limit.
bool PairSocket::SendQueued(std::size_t limit_bytes) {
  for (std::size_t total = 0; !outgoing_.empty();) {
    if (total >= limit_bytes) return true;
    Piece& piece = outgoing_.front();
    const std::size_t first = piece.bytes.size();
    std::array<iovec, 2> parts{};
    std::size_t count = 0;
    if (piece.sent < first) parts[count++] = {piece.bytes.data() + piece.sent, first - piece.sent};
    const Bytes rest = piece.payload.bytes.subspan(piece.sent > first ? piece.sent - first : 0);
    // The system only reads it.
    if (!rest.empty()) parts[count++] = {const_cast<std::byte*>(rest.data()), std::min(rest.size(), kSendBytes)};
    msghdr header{};
    header.msg_iov = parts.data();
    header.msg_iovlen = count;
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
      if (errno != EPIPE && errno != ECONNRESET) return false;
      // The other side has gone. Receive() reports that.
      broken_ = true;
      for (Piece& unsent : outgoing_) spent_.push_back(std::move(unsent.payload));
      outgoing_.clear();
      return false;
    }
    piece.sent += static_cast<std::size_t>(sent);
    total += static_cast<std::size_t>(sent);
    sent_bytes_.fetch_add(static_cast<std::uint64_t>(sent), std::memory_order_relaxed);
    if (piece.sent < first + piece.payload.bytes.size()) continue;
    if (piece.payload.owner) spent_.push_back(std::move(piece.payload));
    outgoing_.pop_front();
  }
  return false;
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
  HandleSet set;
  for (cmsghdr* rights = CMSG_FIRSTHDR(&header); rights != nullptr; rights = CMSG_NXTHDR(&header, rights)) {
    if (rights->cmsg_level != SOL_SOCKET || rights->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (rights->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(rights) + i * sizeof fd, sizeof fd);
      set.handles.emplace_back(fd);
    }
  }
  set.lost = (header.msg_flags & MSG_CTRUNC) != 0;
  // The system gave as many as a frame may have, and the peer sent more. Otherwise this process can open no more.
  if (set.lost && set.handles.size() == kMaxHandles) return Fail("it sends too many descriptors at once");
  if (set.lost || !set.handles.empty()) handles_.push_back(std::move(set));
  if (got == 0) {
    closed_ = true;
    return Read::kClosed;
  }
  if (handles_.size() > kMaxStraySets) return Fail("it sends descriptors without their frames");
  return Read::kFrame;
}

// A large payload is next: from now on its bytes are received into its own memory. False if it is another frame, or if
// its first bytes are not there yet.
bool PairSocket::BeginLarge(std::size_t length) {
  using google::protobuf::io::CodedInputStream;
  const std::size_t available = incoming_.size() - parsed_ - kHeaderBytes;
  if (length <= kReadBytes || available < kMostPrefixBytes) return false;
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(incoming_.data()) + parsed_ + kHeaderBytes,
                      static_cast<int>(kMostPrefixBytes));
  Large large;
  std::uint32_t inner = 0;
  std::uint32_t size = 0;
  if (in.ReadTag() != kPayloadTag || !in.ReadVarint32(&inner)) return false;
  const auto inner_begin = static_cast<std::size_t>(in.CurrentPosition());
  if (in.ReadTag() != kLinkTag || !in.ReadLittleEndian64(&large.apart.link)) return false;
  if (in.ReadTag() != kNumberTag || !in.ReadLittleEndian64(&large.apart.number)) return false;
  if (in.ReadTag() != kDataTag || !in.ReadVarint32(&size)) return false;
  const auto prefix = static_cast<std::size_t>(in.CurrentPosition());
  if (prefix + size != length || inner_begin + inner != length) return false;
  large.size = size;
  // Not touched before its bytes come.
  if (auto* const memory = new (std::align_val_t{alignof(std::max_align_t)}, std::nothrow) std::byte[size]) {
    large.memory = {memory, [](std::byte* bytes) {
                      ::operator delete[](bytes, std::align_val_t{alignof(std::max_align_t)}, std::nothrow);
                    }};
  }
  large.filled = std::min(available - prefix, large.size);
  const auto begin = static_cast<std::size_t>(parsed_ + kHeaderBytes + prefix);
  if (large.memory) std::memcpy(large.memory.get(), incoming_.data() + begin, large.filled);
  parsed_ = begin + large.filled;
  large_ = std::move(large);
  return true;
}

PairSocket::Read PairSocket::ReadLarge() {
  Large& large = *large_;
  std::array<std::byte, 4096> nowhere;
  std::span<std::byte> into(nowhere.data(), std::min(nowhere.size(), large.size - large.filled));
  if (large.memory) into = {large.memory.get() + large.filled, std::min(kLargeReadBytes, large.size - large.filled)};
  const auto got = recv(socket_->fd(), into.data(), into.size(), 0);
  if (got < 0 && errno == EINTR) return Read::kFrame;
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Read::kNothing;
  if (got <= 0) {
    closed_ = true;
    return Read::kClosed;
  }
  received_bytes_ += static_cast<std::uint64_t>(got);
  large.filled += static_cast<std::size_t>(got);
  return Read::kFrame;
}

PairSocket::Read PairSocket::ThrowAway() {
  large_.reset();
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
  frame.payload.reset();
  for (int reads = 0;; ++reads) {
    if (large_) {
      if (large_->filled == large_->size) {
        frame.handles.clear();
        frame.payload = std::move(large_->apart);
        frame.payload->data = {{large_->memory.get(), large_->memory ? large_->size : 0}, large_->memory};
        large_.reset();
        return Read::kFrame;
      }
      if (closed_) return Read::kClosed;
      if (reads == kReadsAtOnce) return Read::kMore;
      if (const Read read = ReadLarge(); read != Read::kFrame) return read;
      continue;
    }
    const std::size_t available = incoming_.size() - parsed_;
    if (available >= kHeaderBytes) {
      std::uint32_t length = 0;
      std::uint32_t count = 0;
      std::memcpy(&length, incoming_.data() + parsed_, sizeof length);
      std::memcpy(&count, incoming_.data() + parsed_ + sizeof length, sizeof count);
      if (length > max_frame_bytes_) return Fail("it sends a frame of " + std::to_string(length) + " bytes");
      if (count > kMaxHandles) return Fail("it sends too many descriptors at once");
      if (available >= kHeaderBytes + length) {
        frame.handles.clear();
        frame.handles_lost = false;
        if (count > 0) {
          const bool lost = !handles_.empty() && handles_.front().lost;
          if (handles_.empty() || (!lost && handles_.front().handles.size() != count)) {
            return Fail("a frame comes without its descriptors");
          }
          frame.handles_lost = lost;
          if (!lost) frame.handles = std::move(handles_.front().handles);
          handles_.pop_front();
        }
        const bool parsed =
            frame.message.ParseFromArray(incoming_.data() + parsed_ + kHeaderBytes, static_cast<int>(length));
        parsed_ += kHeaderBytes + length;
        if (!parsed) return Fail("it sends a frame that does not parse");
        if (frame.message.has_payload()) {
          auto& payload = *frame.message.mutable_payload();
          auto data = std::make_shared<const std::string>(std::move(*payload.mutable_data()));
          frame.payload = Apart{payload.link(), payload.number(), {AsBytes(*data), data}};
        }
        return Read::kFrame;
      }
      if (count == 0 && BeginLarge(length)) continue;
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

OtherSide OtherSideOf(const Handle& connection) noexcept {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (getsockopt(connection.fd(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return {};
  return {credentials.uid, credentials.pid};
}

Handle AcceptFrom(const Handle& listening, bool& out_of_descriptors) noexcept {
  Handle made(accept4(listening.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  out_of_descriptors = !made.valid() && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM);
  return made;
}

Handle ConnectTo(const std::string& place, std::string& fault, bool& wait) {
  sockaddr_un address;
  socklen_t size = 0;
  if (!AddressOf(place, address, size, fault)) return {};
  Handle made = MakeSocket(fault);
  if (!made.valid()) return {};
  if (wait) {  // Any user may have filled the place's queue.
    (void)fcntl(made.fd(), F_SETFL, 0);
    const timeval patience{0, kWaitForRoomUs};
    (void)setsockopt(made.fd(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }
  int failed = 0;
  do {
    failed = connect(made.fd(), reinterpret_cast<const sockaddr*>(&address), size);
  } while (failed != 0 && errno == EINTR);
  if (failed != 0) {
    wait = wait && errno != EAGAIN;
    fault = errno == EAGAIN ? "too many connections wait at \"" + place + "\""
                            : "nobody listens at \"" + place + "\" in this network namespace: " + std::strerror(errno);
    return {};
  }
  (void)fcntl(made.fd(), F_SETFL, O_NONBLOCK);
  return made;
}

}  // namespace hgros::shm
