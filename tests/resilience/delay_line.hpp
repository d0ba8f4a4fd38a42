#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <string>
#include <thread>

#include "support/relay_port.hpp"

namespace hgros::resilience {

/// Passes TCP connections on to another port, of this host if no other is given, and delays each byte by `each_way`.
class DelayLine {
 public:
  DelayLine(std::uint16_t target_port, std::chrono::milliseconds each_way, const char* target_ip = "127.0.0.1");
  DelayLine(const DelayLine&) = delete;
  DelayLine& operator=(const DelayLine&) = delete;
  ~DelayLine();
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

  void Run();
  void Accept();
  void Read(Connection& connection, Lane& lane);
  static void Write(Connection& connection, Lane& lane, Time now);
  static void Close(const Connection& connection);

  const test::RelayPort relay_;
  const std::chrono::milliseconds each_way_;
  int stop_[2] = {-1, -1};
  std::list<Connection> connections_;  // Only the thread uses them.
  std::thread thread_;
};

}  // namespace hgros::resilience
