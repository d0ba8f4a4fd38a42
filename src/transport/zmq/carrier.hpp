#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string_view>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/transport.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "transport/actions.hpp"
#include "transport/agreement.hpp"
#include "transport/peer_registry.hpp"
#include "transport/waker.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

using SteadyTime = std::chrono::steady_clock::time_point;

/// What all endpoints of one transport share.
/// Thread safety: all of it; `options` and `self` never change.
struct Carrier {
  Carrier(ZmqOptions given, TransportListener& told, Log& voice);

  /// Counts a packet that was dropped, and says so once in a while. `where` is an endpoint or a peer.
  void CountFault(PacketFault fault, std::string_view where, std::string_view what);
  [[nodiscard]] Time Wall() const { return options.wall ? options.wall() : WallNow(); }
  /// Has the leading thread make these calls.
  void Post(Actions&& actions);
  [[nodiscard]] Actions TakePosted();

  const ZmqOptions options;
  const SessionFacts self;
  TransportListener& listener;
  Log& log;
  ForkGuard fork;
  const std::shared_ptr<Waker> waker = std::make_shared<Waker>();
  PeerRegistry peers;
  std::array<std::atomic<std::uint64_t>, kPacketFaultCount> faults{};
  std::atomic<std::uint64_t> repeats{0};
  std::atomic<bool> closing{false};
  Context context;

 private:
  std::mutex posted_mutex_;
  Actions posted_;
};

/// Uses a socket from a thread that does not read from it. Sending works through the socket's commands as well, and
/// that may swallow the signal for input that has come: so at the end of use the waiting thread is told to look.
class SocketUse {
 public:
  SocketUse(std::mutex& mutex, Socket& socket, std::atomic<bool>& input, Waker& waker)
      : lock_(mutex), socket_(socket), input_(input), waker_(waker) {}
  ~SocketUse() {
    if (!socket_.HasInput()) return;
    if (!input_.exchange(true)) waker_.Wake();
  }
  SocketUse(const SocketUse&) = delete;
  SocketUse& operator=(const SocketUse&) = delete;

 private:
  std::scoped_lock<std::mutex> lock_;
  Socket& socket_;
  std::atomic<bool>& input_;
  Waker& waker_;
};

}  // namespace hgros::zmq
