#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "conformance/transport_conformance.hpp"
#include "support/relay_port.hpp"

namespace hgros::conformance {

/// Passes TCP connections on to another port of this host, and can stall and cut them.
class TcpForwarder : public Cable {
 public:
  explicit TcpForwarder(std::uint16_t target_port);
  ~TcpForwarder() override;
  [[nodiscard]] std::uint16_t port() const { return relay_.port(); }
  void Stall() override;
  void Resume() override;
  void Cut() override;

 private:
  enum class State { kOpen, kStalled, kCut };
  void Run();
  void Set(State state);

  const test::RelayPort relay_;
  int wake_[2] = {-1, -1};
  std::mutex mutex_;
  std::condition_variable changed_;
  State wanted_ = State::kOpen;
  State reached_ = State::kOpen;
  bool stop_ = false;
  std::vector<test::RelayPort::Pair> pairs_;  // Only the thread uses them.
  std::thread thread_;
};

}  // namespace hgros::conformance
