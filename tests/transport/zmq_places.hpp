#pragma once

#include <stdlib.h>
#include <zmq.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros::test {

/// A folder that is removed at the end of the test.
class Folder {
 public:
  Folder() {
    std::string pattern = std::filesystem::temp_directory_path() / "hgros-XXXXXX";
    path_ = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string Ipc(const std::string& name = "socket") const { return "ipc://" + path_ + "/" + name; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A transport with its listener.
struct Place {
  explicit Place(ZmqOptions options, std::chrono::milliseconds peer_timeout = std::chrono::seconds(3)) {
    options.heartbeat = std::chrono::milliseconds(100);
    options.peer_timeout = peer_timeout;
    options.plain_after = std::chrono::milliseconds(50);
    options.unreachable_after = std::chrono::milliseconds(200);
    transport = MakeZmqTransport(std::move(options), listener, log);
  }
  /// True if a line of the log contains this text.
  [[nodiscard]] bool Said(std::string_view text) { return TimesSaid(text) > 0; }
  [[nodiscard]] std::ptrdiff_t TimesSaid(std::string_view text) {
    const std::scoped_lock lock(mutex);
    return std::ranges::count_if(lines, [&](const auto& line) { return line.find(text) != std::string::npos; });
  }
  std::mutex mutex;
  std::vector<std::string> lines;  // Guarded by mutex.
  conformance::Listener listener;
  Log log{[this](LogLevel, std::string_view text) {
    const std::scoped_lock lock(mutex);
    lines.emplace_back(text);
  }};
  std::unique_ptr<ZmqTransport> transport;
};

/// How often a limit was exceeded.
inline std::uint64_t Overruns(const Place& place) {
  return place.transport->stats().faults[static_cast<std::size_t>(PacketFault::kOverrun)];
}

inline ZmqOptions PublishAt(const std::string& endpoint) {
  ZmqOptions options;
  options.publish = {{endpoint, std::nullopt}};
  return options;
}

inline ZmqOptions SubscribeAt(const std::string& endpoint) {
  ZmqOptions options;
  options.subscribe = {{endpoint, std::nullopt, {}}};
  return options;
}

/// A plain ZeroMQ socket, without this library.
class RawSocket {
 public:
  explicit RawSocket(int type) : context_(std::make_shared<Context>()), socket_(zmq_socket(context_->raw, type)) {
    const int linger = 0;
    zmq_setsockopt(socket_, ZMQ_LINGER, &linger, sizeof linger);
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
  void Send(const std::vector<std::string>& frames) const {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      zmq_send(socket_, frames[i].data(), frames[i].size(), i + 1 < frames.size() ? ZMQ_SNDMORE : 0);
    }
  }
  /// The next message's frames; empty at the deadline.
  [[nodiscard]] std::vector<std::string> Receive(int deadline_ms = 10000) const {
    zmq_setsockopt(socket_, ZMQ_RCVTIMEO, &deadline_ms, sizeof deadline_ms);
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
  std::shared_ptr<Context> context_;
  void* socket_;
};

}  // namespace hgros::test
