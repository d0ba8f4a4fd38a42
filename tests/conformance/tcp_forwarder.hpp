#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "conformance/transport_conformance.hpp"
#include "support/relay_port.hpp"

namespace hgros::conformance {

/// Passes TCP connections on to another port, of this host if no other is given, and can stall and cut them. Delays
/// each byte by `each_way`.
class TcpForwarder : public Cable {
 public:
  explicit TcpForwarder(std::uint16_t target_port, std::chrono::milliseconds each_way = {},
                        const char* target_ip = "127.0.0.1");
  ~TcpForwarder() override;
  [[nodiscard]] std::uint16_t port() const { return relay_.port(); }
  void Stall() override;
  void Resume() override;
  void Cut() override;

 private:
  using Time = std::chrono::steady_clock::time_point;
  enum class State { kOpen, kStalled, kCut };
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

  static void Close(const Connection& connection);
  void Accept();
  void Read(Connection& connection, Lane& lane) const;
  static void Write(Connection& connection, Lane& lane);
  void Run();
  void Set(State state);

  const test::RelayPort relay_;
  const std::chrono::milliseconds each_way_;
  int wake_[2] = {-1, -1};
  std::mutex mutex_;
  std::condition_variable changed_;
  State wanted_ = State::kOpen;
  State reached_ = State::kOpen;
  bool stop_ = false;
  std::list<Connection> connections_;  // Only the thread uses them.
  std::thread thread_;
};

}  // namespace hgros::conformance
