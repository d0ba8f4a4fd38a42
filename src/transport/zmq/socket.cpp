#include "transport/zmq/socket.hpp"

#include <cerrno>
#include <cstring>
#include <new>

#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kThreads = 4;  // Two of ZeroMQ, and as many that receive.

[[noreturn]] void ThrowZmq(std::string_view what) {
  throw Error(std::string(what) + ": " + zmq_strerror(zmq_errno()) + ".");
}

}  // namespace

Context::Context() : raw_(nullptr) {
  RequireDescriptors(kSpareDescriptors, "Cannot use ZeroMQ");
  RequireThreads(kThreads, "ZeroMQ and the threads that receive from it");
  raw_ = zmq_ctx_new();
  if (raw_ == nullptr) ThrowZmq("Cannot create a ZeroMQ context");
  zmq_ctx_set(raw_, ZMQ_MAX_SOCKETS, kMostSockets);
  // The first socket starts the threads.
  void* const first = zmq_socket(raw_, ZMQ_PAIR);
  const int error = zmq_errno();
  if (first != nullptr) {
    zmq_close(first);
    return;
  }
  zmq_ctx_term(raw_);
  errno = error;
  ThrowZmq("Cannot start ZeroMQ");
}

void Context::Terminate() noexcept {
  void* const raw = std::exchange(raw_, nullptr);
  while (raw != nullptr && zmq_ctx_term(raw) != 0 && zmq_errno() == EINTR) {
  }
}

Message Message::CopyOf(Bytes bytes) {
  Message message;
  if (zmq_msg_init_size(&message.raw_, bytes.size()) != 0) {
    zmq_msg_init(&message.raw_);
    throw std::bad_alloc();
  }
  if (!bytes.empty()) std::memcpy(zmq_msg_data(&message.raw_), bytes.data(), bytes.size());
  return message;
}

Message Message::View(Bytes bytes, void (*release)(void*, void*), void* hint) {
  Message message;
  // ZeroMQ wants a mutable pointer but does not write to what it sends.
  auto* data = const_cast<std::byte*>(bytes.data());
  if (zmq_msg_init_data(&message.raw_, data, bytes.size(), release, hint) != 0) {
    zmq_msg_init(&message.raw_);
    release(data, hint);
    throw std::bad_alloc();
  }
  return message;
}

Socket::Socket(Context& context, int type) : raw_(nullptr) {
  RequireDescriptors(kSpareDescriptors, "Cannot create a ZeroMQ socket");
  raw_ = zmq_socket(context.raw(), type);
  if (raw_ == nullptr && zmq_errno() == EMFILE && FreeDescriptors(kSpareDescriptors) == kSpareDescriptors) {
    throw Error("Cannot create a ZeroMQ socket: this session has " + std::to_string(kMostSockets) +
                    " already, three for each endpoint that it subscribes to.",
                {}, "Use fewer endpoints, or several sessions.");
  }
  if (raw_ == nullptr) ThrowZmq("Cannot create a ZeroMQ socket");
  // ZeroMQ ends a connection that was accepted and has broken with the value that its socket had when it was bound, and
  // would wait without a limit for what that connection has not sent, also in zmq_ctx_term().
  const int linger_ms = 0;
  zmq_setsockopt(raw_, ZMQ_LINGER, &linger_ms, sizeof linger_ms);
}

void Socket::Set(int option, int value) {
  if (zmq_setsockopt(raw_, option, &value, sizeof value) != 0) {
    ThrowZmq("ZeroMQ refuses option " + std::to_string(option) + " = " + std::to_string(value));
  }
}

void Socket::Set(int option, std::int64_t value) {
  if (zmq_setsockopt(raw_, option, &value, sizeof value) != 0) {
    ThrowZmq("ZeroMQ refuses option " + std::to_string(option) + " = " + std::to_string(value));
  }
}

void Socket::Set(int option, std::string_view value) {
  // The value may be a secret key: the error does not contain it.
  if (zmq_setsockopt(raw_, option, value.data(), value.size()) != 0) {
    ThrowZmq("ZeroMQ refuses the text of option " + std::to_string(option));
  }
}

int Socket::Bind(const std::string& endpoint) { return zmq_bind(raw_, endpoint.c_str()) == 0 ? 0 : zmq_errno(); }

int Socket::Connect(const std::string& endpoint) { return zmq_connect(raw_, endpoint.c_str()) == 0 ? 0 : zmq_errno(); }

void Socket::Disconnect(const std::string& endpoint) noexcept { zmq_disconnect(raw_, endpoint.c_str()); }

std::string Socket::LastEndpoint() const {
  char text[512];
  std::size_t size = sizeof text;
  if (zmq_getsockopt(raw_, ZMQ_LAST_ENDPOINT, text, &size) != 0 || size == 0) return {};
  return std::string(text, size - 1);
}

int Socket::Fd() const {
  int fd = -1;
  std::size_t size = sizeof fd;
  if (zmq_getsockopt(raw_, ZMQ_FD, &fd, &size) != 0) ThrowZmq("ZeroMQ returns no descriptor");
  return fd;
}

bool Socket::HasInput() noexcept {
  if (raw_ == nullptr) return false;
  int events = 0;
  std::size_t size = sizeof events;
  while (zmq_getsockopt(raw_, ZMQ_EVENTS, &events, &size) != 0) {
    if (zmq_errno() != EINTR) return false;
  }
  return (events & ZMQ_POLLIN) != 0;
}

bool Socket::Receive(Message& frame) noexcept {
  if (raw_ == nullptr) return false;
  while (zmq_msg_recv(frame.raw(), raw_, ZMQ_DONTWAIT) < 0) {
    if (zmq_errno() != EINTR) return false;
  }
  return true;
}

bool Socket::Send(std::string_view frame, bool more) noexcept {
  if (raw_ == nullptr) return false;
  while (zmq_send(raw_, frame.data(), frame.size(), ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) < 0) {
    if (zmq_errno() != EINTR) return false;
  }
  return true;
}

bool Socket::Send(Message& frame, bool more) noexcept {
  if (raw_ == nullptr) return false;
  while (zmq_msg_send(frame.raw(), raw_, ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) < 0) {
    if (zmq_errno() != EINTR) return false;
  }
  return true;
}

void Socket::Close(int linger_ms) noexcept {
  if (raw_ == nullptr) return;
  zmq_setsockopt(raw_, ZMQ_LINGER, &linger_ms, sizeof linger_ms);
  zmq_close(raw_);
  raw_ = nullptr;
}

}  // namespace hgros::zmq
