#pragma once

#include <fcntl.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/relay_port.hpp"

namespace hgros::resilience {

/// Passes TCP connections on to another port, of this host if no other is given, and delays each byte by `each_way`.
class DelayLine {
 public:
  DelayLine(std::uint16_t target_port, std::chrono::milliseconds each_way, const char* target_ip = "127.0.0.1")
      : relay_(target_port, target_ip), each_way_(each_way) {
    if (pipe2(stop_, O_CLOEXEC) != 0) throw std::runtime_error("no delay line");
    thread_ = std::thread([this] { Run(); });
  }
  DelayLine(const DelayLine&) = delete;
  DelayLine& operator=(const DelayLine&) = delete;
  ~DelayLine() {
    close(stop_[1]);
    thread_.join();
    for (const Connection& connection : connections_) Close(connection);
    close(stop_[0]);
  }
  [[nodiscard]] std::uint16_t port() const { return relay_.port(); }

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Piece {
    Time due;
    std::string bytes;
  };
  /// One direction of a connection.
  struct Lane {
    int from = -1;
    int to = -1;
    std::deque<Piece> pieces;
  };
  struct Connection {
    Lane lanes[2];
    bool ended = false;
  };

  static void Close(const Connection& connection) {
    close(connection.lanes[0].from);
    close(connection.lanes[0].to);
  }
  void Accept() {
    const auto pair = relay_.Accept();
    if (!pair) return;
    fcntl(pair->client, F_SETFL, O_NONBLOCK);
    fcntl(pair->server, F_SETFL, O_NONBLOCK);
    Connection& connection = connections_.emplace_back();
    connection.lanes[0] = {pair->client, pair->server, {}};
    connection.lanes[1] = {pair->server, pair->client, {}};
  }
  void Read(Connection& connection, Lane& lane) const {
    std::string bytes(65536, '\0');
    const ssize_t size = recv(lane.from, bytes.data(), bytes.size(), 0);
    if (size <= 0) {
      connection.ended = size == 0 || (errno != EAGAIN && errno != EINTR);
      return;
    }
    bytes.resize(static_cast<std::size_t>(size));
    lane.pieces.push_back({std::chrono::steady_clock::now() + each_way_, std::move(bytes)});
  }
  static void Write(Connection& connection, Lane& lane, Time now) {
    while (!lane.pieces.empty() && lane.pieces.front().due <= now) {
      std::string& bytes = lane.pieces.front().bytes;
      const ssize_t sent = send(lane.to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0) {
        connection.ended = connection.ended || (errno != EAGAIN && errno != EINTR);
        return;
      }
      bytes.erase(0, static_cast<std::size_t>(sent));
      if (bytes.empty()) lane.pieces.pop_front();
    }
  }

  void Run() {
    for (;;) {
      std::vector<pollfd> fds{{stop_[0], POLLIN, 0}, {relay_.listener(), POLLIN, 0}};
      const Time now = std::chrono::steady_clock::now();
      Time wake = now + std::chrono::hours(1);
      for (Connection& connection : connections_) {
        for (const Lane& lane : connection.lanes) {
          const bool due = !lane.pieces.empty() && lane.pieces.front().due <= now;
          if (!lane.pieces.empty() && !due) wake = std::min(wake, lane.pieces.front().due);
          fds.push_back({lane.from, POLLIN, 0});
          fds.push_back({lane.to, static_cast<short>(due ? POLLOUT : 0), 0});
        }
      }
      const auto patience = std::chrono::ceil<std::chrono::milliseconds>(wake - now).count();
      poll(fds.data(), fds.size(), static_cast<int>(patience));
      if (fds[0].revents != 0) return;
      const Time after = std::chrono::steady_clock::now();
      std::size_t i = 2;
      for (Connection& connection : connections_) {
        for (Lane& lane : connection.lanes) {
          if (fds[i].revents != 0) Read(connection, lane);
          Write(connection, lane, after);
          i += 2;
        }
      }
      std::erase_if(connections_, [](const Connection& connection) {
        if (connection.ended) Close(connection);
        return connection.ended;
      });
      if (fds[1].revents != 0) Accept();
    }
  }

  const test::RelayPort relay_;
  const std::chrono::milliseconds each_way_;
  int stop_[2] = {-1, -1};
  std::list<Connection> connections_;  // Only the thread uses them.
  std::thread thread_;
};

}  // namespace hgros::resilience
