#pragma once

#include <atomic>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "transport/zmq/socket.hpp"

namespace hgros {
struct ZmqSecurity;
class Log;
}  // namespace hgros

namespace hgros::zmq {

/// Make a socket speak CURVE only. Throw Error for invalid keys.
void SecureServer(Socket& socket, const ZmqSecurity& security);
void SecureClient(Socket& socket, const ZmqSecurity& security, const std::string& server_key);

/// The one way in which this public key is written. Throws Error for an invalid one, which tells `whose` key it is.
[[nodiscard]] std::string KeyText(const std::string& key, std::string_view whose);

/// Answers ZeroMQ's question whether a client may connect (https://rfc.zeromq.org/spec/27/): only clients whose public
/// key is on the list may. Messages of that client have its KeyText() as Message::user_id(). It must be created before
/// the first socket is bound. Thread safety: Serve() belongs to the leading thread; refused() is thread-safe.
class AdmissionDesk {
 public:
  AdmissionDesk(Context& context, const ZmqSecurity& security, Log& log);
  [[nodiscard]] int fd() const noexcept { return fd_; }
  void Serve();
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }
  void Close() { socket_.Close(0); }

 private:
  Socket socket_;
  int fd_;
  Log& log_;
  std::set<std::string, std::less<>> allowed_;  // 32-byte keys.
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace hgros::zmq
