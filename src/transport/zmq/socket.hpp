#pragma once

#include <zmq.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/bytes.hpp"

namespace hgros::zmq {

/// ZeroMQ ends the process if it lacks descriptors or threads at the wrong moment. So this many descriptors must be
/// free before it gets something to do.
inline constexpr std::size_t kSpareDescriptors = 16;

/// Sockets of one context; ZeroMQ allows 1023 unless told. It takes 12 bytes for each when it starts. An endpoint that
/// is subscribed to has three.
inline constexpr int kMostSockets = 16384;

/// Owns a ZeroMQ context, whose threads run from the beginning. It is destroyed after its sockets, and waits for their
/// linger.
class Context {
 public:
  /// Throws Error.
  Context();
  ~Context() { Terminate(); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  [[nodiscard]] void* raw() const noexcept { return raw_; }
  /// Waits until the sockets, which are all closed, have sent what they linger for.
  void Terminate() noexcept;
  /// Forgets the context without touching it, for a forked child.
  void Abandon() noexcept { raw_ = nullptr; }

 private:
  void* raw_;
};

/// Owns one frame.
class Message {
 public:
  Message() noexcept { zmq_msg_init(&raw_); }
  ~Message() { zmq_msg_close(&raw_); }
  Message(Message&& other) noexcept {
    zmq_msg_init(&raw_);
    zmq_msg_move(&raw_, &other.raw_);
  }
  Message& operator=(Message&& other) noexcept {
    if (this != &other) zmq_msg_move(&raw_, &other.raw_);
    return *this;
  }

  /// Throws std::bad_alloc.
  [[nodiscard]] static Message CopyOf(Bytes bytes);
  /// Sends `bytes` in place, without a copy. `release` is called with `hint`, on any thread, when they are no longer
  /// needed.
  [[nodiscard]] static Message View(Bytes bytes, void (*release)(void* data, void* hint), void* hint);

  [[nodiscard]] Bytes bytes() const noexcept {
    auto* message = const_cast<zmq_msg_t*>(&raw_);
    return {static_cast<const std::byte*>(zmq_msg_data(message)), zmq_msg_size(message)};
  }
  /// The user id that the ZAP handler gave to the sender's connection, and that connection's address; empty: none.
  [[nodiscard]] std::string_view user_id() const noexcept { return Property("User-Id"); }
  [[nodiscard]] std::string_view peer_address() const noexcept { return Property("Peer-Address"); }
  [[nodiscard]] bool more() const noexcept { return zmq_msg_more(&raw_) != 0; }
  [[nodiscard]] zmq_msg_t* raw() noexcept { return &raw_; }

 private:
  [[nodiscard]] std::string_view Property(const char* name) const noexcept {
    const char* const text = zmq_msg_gets(&raw_, name);
    return text == nullptr ? std::string_view() : text;
  }

  zmq_msg_t raw_;
};

/// Owns a socket.
///
/// Thread safety: none; the owner guards it with a mutex, which is the full fence that ZeroMQ asks for when a socket
/// changes threads. The descriptor of Fd() may be polled without it.
class Socket {
 public:
  /// Throws Error.
  Socket(Context& context, int type);
  ~Socket() { Close(0); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void Set(int option, int value);
  void Set(int option, std::int64_t value);
  void Set(int option, std::string_view value);
  /// 0, or the errno of the attempt.
  [[nodiscard]] int Bind(const std::string& endpoint);
  [[nodiscard]] int Connect(const std::string& endpoint);
  void Disconnect(const std::string& endpoint) noexcept;
  [[nodiscard]] std::string LastEndpoint() const;
  [[nodiscard]] int Fd() const;
  /// True if a message can be received. Also handles the socket's pending commands, after which Fd() signals only new
  /// ones: if this returns true, the caller must receive or make sure that another thread does.
  [[nodiscard]] bool HasInput() noexcept;
  /// Receives one frame without waiting; false if there is none.
  bool Receive(Message& frame) noexcept;
  /// Sends without waiting; false only if the socket is closed or its context is ending.
  bool Send(std::string_view frame, bool more) noexcept;
  bool Send(Message& frame, bool more) noexcept;
  void Close(int linger_ms) noexcept;
  void Abandon() noexcept { raw_ = nullptr; }
  [[nodiscard]] bool closed() const noexcept { return raw_ == nullptr; }
  [[nodiscard]] void* raw() const noexcept { return raw_; }

 private:
  void* raw_;
};

}  // namespace hgros::zmq
