#pragma once

#include <atomic>
#include <mutex>

#include "transport/waker.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// Locks a socket for a thread that does not read from it.
///
/// Sending also handles the socket's internal commands, and may use up the signal that input has arrived. So if there
/// is input when the use ends, `input` is set and the waiting thread is woken.
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
