#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "transport/zmq/publish/accepted_connections.hpp"
#include "transport/zmq/publish/unfinished_messages.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// Watches the connections that a publish endpoint accepts. ZeroMQ has no limit for them, and its thread uses up a CPU
/// while a connection waits that it cannot accept.
///
/// - At most kMostSilent tcp connections of one address may exist that have not sent a whole greeting of ZMTP; further
///   ones are closed. ZeroMQ itself closes each after kHandshakeMs.
/// - AcceptedConnections and UnfinishedMessages have further limits.
/// - A plain subscriber that does not read is cut off before it uses up the bytes that all plain subscribers share.
/// - While the process has no file descriptors left, the endpoint does not listen. At an ipc path it stops while some
///   are left: ZeroMQ 4.3 ends the process if it cannot accept a connection there.
///
/// Thread safety: none; the endpoint's mutex guards it. The descriptor of fd() may be polled without it.
class ConnectionWatch {
 public:
  static constexpr int kHandshakeMs = 10'000;
  static constexpr std::size_t kMostSilent = 64;

  /// Call it before the socket is bound. `bound` is set later. Throws Error.
  ConnectionWatch(SharedState& shared, Socket& socket, const std::string& bound);
  ~ConnectionWatch();
  ConnectionWatch(const ConnectionWatch&) = delete;
  ConnectionWatch& operator=(const ConnectionWatch&) = delete;

  [[nodiscard]] int fd() const { return monitor_.Fd(); }
  /// To be set when the descriptor has become readable.
  [[nodiscard]] std::atomic<bool>& input() noexcept { return input_; }
  /// Reads what has happened, if input() is set. True if there may be more.
  bool Serve();
  /// Reads what has happened, whether input() is set or not.
  bool Update();
  void Tick();
  void Close() noexcept;

  [[nodiscard]] UnfinishedMessages& unfinished() noexcept { return unfinished_; }
  /// To be called when UnfinishedMessages::IsLookDue() and everything that was delivered has been read.
  void CutUnfinished();

  /// The connection with this descriptor has subscribed to `topic`, or no longer; negative: not known. False if it has
  /// subscribed to too much and was closed.
  [[nodiscard]] bool CountTopic(int fd, std::string_view topic, bool subscribed);
  /// It is that of a plain subscriber.
  void NotePlain(int fd);
  /// It is that of a session, which has limits of its own.
  void NoteSession(int fd);
  /// To be called for each plain message while more than half of the shared bytes are in use. Closes the connections
  /// whose send buffers have been full for a while, if there are others with room.
  void CutStuckPlain(SteadyTime now);

 private:
  void OnAccepted(int fd);
  void OnHandshakeFailed(int fd, std::int32_t failure);
  void StopIfIpcIsInDanger();
  void StopListening();
  void ListenAgain();

  SharedState& shared_;
  Socket& socket_;
  const std::string& bound_;
  Socket monitor_;
  std::atomic<bool> input_{true};
  bool listens_ = true;
  std::unordered_map<int, int> plain_;  // How often in a row the send buffer was full.
  SteadyTime next_look_{};
  AcceptedConnections connections_;
  UnfinishedMessages unfinished_;
  std::int32_t handshake_failure_ = 0;           // Of the connection whose end is reported next.
  std::unordered_map<int, std::string> silent_;  // Addresses of connections that may not have sent a greeting.
};

}  // namespace hgros::zmq
