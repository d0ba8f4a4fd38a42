#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zmq.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "conformance/transport_conformance.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {

using Folder = ScratchFolder;

/// A transport with its listener.
struct Place : conformance::KeptLog {
  explicit Place(ZmqOptions options, std::chrono::milliseconds peer_timeout = std::chrono::seconds(3)) {
    options.heartbeat = std::chrono::milliseconds(100);
    options.peer_timeout = peer_timeout;
    options.plain_after = std::chrono::milliseconds(50);
    options.unreachable_after = std::chrono::milliseconds(200);
    transport = MakeZmqTransport(std::move(options), listener, log);
  }
  [[nodiscard]] std::string Bound() const { return transport->BoundEndpoints().front(); }
  [[nodiscard]] std::uint64_t Faults(PacketFault fault) const {
    return transport->stats().faults[static_cast<std::size_t>(fault)];
  }
  /// How often a limit was exceeded.
  [[nodiscard]] std::uint64_t Overruns() const { return Faults(PacketFault::kOverrun); }

  conformance::Listener listener;
  std::unique_ptr<ZmqTransport> transport;
};

constexpr const char* kAnyPort = "tcp://127.0.0.1:*";

/// Whether this host has the loopback of IPv6.
inline bool HasIp6() {
  const int fd = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  const bool has = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return has;
}

inline ZmqOptions PublishAt(const std::string& endpoint = kAnyPort,
                            std::uint64_t plain_queue_bytes = ZmqOptions().plain_queue_bytes) {
  ZmqOptions options;
  options.publish = {{endpoint, std::nullopt}};
  options.plain_queue_bytes = plain_queue_bytes;
  return options;
}

inline ZmqOptions SubscribeAt(const std::string& endpoint, SessionId session = {}) {
  ZmqOptions options;
  options.session = session;
  options.subscribe = {{endpoint, std::nullopt, {}}};
  return options;
}

/// Whether a session that subscribes there reaches a publisher.
inline bool IsReached(const std::string& endpoint) {
  const Place subscriber(SubscribeAt(endpoint));
  return conformance::Eventually([&] { return subscriber.listener.came == 1; });
}

/// A plain ZeroMQ socket, without this library.
class RawSocket {
 public:
  explicit RawSocket(int type) : context_(std::make_shared<Context>()), socket_(zmq_socket(context_->raw, type)) {
    Set(ZMQ_LINGER, 0);
  }
  /// A plain subscriber to the channel, for which so many messages may wait.
  RawSocket(const std::string& endpoint, std::string_view channel, int most_waiting = 1000) : RawSocket(ZMQ_SUB) {
    Set(ZMQ_RCVHWM, most_waiting);
    Set(ZMQ_SUBSCRIBE, PlainTopic(channel));
    Connect(endpoint);
  }
  /// Receives these `events` of another socket.
  RawSocket(const RawSocket& watched, const char* address, int events)
      : context_(watched.context_), socket_(zmq_socket(context_->raw, ZMQ_PAIR)) {
    zmq_socket_monitor(watched.get(), address, events);
    zmq_connect(socket_, address);
  }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;
  ~RawSocket() { zmq_close(socket_); }
  [[nodiscard]] void* get() const { return socket_; }
  void Set(int option, int value) const { Require(zmq_setsockopt(socket_, option, &value, sizeof value)); }
  void Set(int option, std::string_view value) const {
    Require(zmq_setsockopt(socket_, option, value.data(), value.size()));
  }
  void Bind(const std::string& endpoint) const { Require(zmq_bind(socket_, endpoint.c_str())); }
  void Connect(const std::string& endpoint) const { Require(zmq_connect(socket_, endpoint.c_str())); }
  void Send(const std::vector<std::string>& frames) const {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      zmq_send(socket_, frames[i].data(), frames[i].size(), i + 1 < frames.size() ? ZMQ_SNDMORE : 0);
    }
  }
  /// The next message's frames; empty at the deadline.
  [[nodiscard]] std::vector<std::string> Receive(int deadline_ms = 10000) const {
    Set(ZMQ_RCVTIMEO, deadline_ms);
    std::vector<std::string> frames;
    for (bool more = true; more;) {
      zmq_msg_t frame;
      zmq_msg_init(&frame);
      if (zmq_msg_recv(&frame, socket_, 0) < 0) return {};
      frames.emplace_back(static_cast<const char*>(zmq_msg_data(&frame)), zmq_msg_size(&frame));
      more = zmq_msg_more(&frame) != 0;
      zmq_msg_close(&frame);
    }
    return frames;
  }

 private:
  struct Context {
    Context() = default;
    ~Context() { zmq_ctx_term(raw); }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    void* raw = zmq_ctx_new();
  };
  static void Require(int result) {
    if (result != 0) throw std::runtime_error(zmq_strerror(zmq_errno()));
  }

  std::shared_ptr<Context> context_;
  void* socket_;
};

/// A frame of ZMTP 3 (https://rfc.zeromq.org/spec/23).
inline std::string Frame(std::string_view body, bool more = false) {
  std::string frame;
  if (body.size() < 256) {
    frame += static_cast<char>(more ? 1 : 0);
    frame += static_cast<char>(body.size());
  } else {
    frame += static_cast<char>(more ? 3 : 2);
    for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(body.size() >> shift & 0xff);
  }
  return frame.append(body);
}

/// The greeting without keys and the READY command of a socket type with four letters.
inline std::string Greeting(std::string_view socket_type) {
  std::string greeting("\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL", 16);
  greeting.resize(64);
  return (greeting + std::string("\4\x1a\5READY\13Socket-Type\0\0\0\4", 24)).append(socket_type);
}

/// A publisher of "scan", and its subscribers: a session and a plain one.
struct Audience {
  /// `from`: the address of the session, and ";".
  explicit Audience(const std::string& at, const std::string& from = {},
                    std::chrono::milliseconds peer_timeout = std::chrono::seconds(3))
      : publisher(PublishAt(at), peer_timeout),
        session(SubscribeAt(std::string(endpoint).insert(6, from), SessionId{7}), peer_timeout) {
    EXPECT_TRUE(out.Joined(2));
  }
  /// Both get what is published.
  void ExpectMessages() {
    const std::size_t before = in.sink.count();
    ASSERT_EQ(out.Publish("go on"), PublishStatus::kOk);
    EXPECT_TRUE(conformance::Eventually([&] { return in.sink.count() > before; }));
    EXPECT_EQ(plain.Receive().size(), 3u);
    EXPECT_EQ(session.listener.gone, 0);
  }

  Place publisher;
  const std::string endpoint = publisher.Bound();
  Place session;
  conformance::Publication out{*publisher.transport, "scan"};
  conformance::Reception in{*session.transport, "scan"};
  const RawSocket plain{endpoint, "scan"};
};

}  // namespace hgros::test
