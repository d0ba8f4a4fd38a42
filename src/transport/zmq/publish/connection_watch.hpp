#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "transport/zmq/publish/accepted_connections.hpp"
#include "transport/zmq/publish/unfinished_messages.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// Watches the connections that a publish endpoint accepts. ZeroMQ has no limit for them, and its thread uses up a CPU
/// while a connection waits that it cannot accept.
///
/// - AcceptedConnections and UnfinishedMessages have limits.
/// - While the process has no file descriptors left, connections that wait at a tcp endpoint are closed.
/// - ZeroMQ 4.3 ends the process if it cannot accept a connection at an ipc endpoint. So while few descriptors are
///   left, the socket's file has another name, and nobody finds it.
/// - An endpoint where that is impossible stops listening. ZeroMQ then ends all its connections.
///
/// Thread safety: none; the endpoint's mutex guards it. The descriptor of fd() may be polled without it.
class ConnectionWatch {
 public:
  static constexpr int kHandshakeMs = 10'000;

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

  /// Whether the socket is bound. It may not be while descriptors are scarce.
  [[nodiscard]] bool listens() const noexcept { return listening_ != Listening::kClosed; }
  [[nodiscard]] UnfinishedMessages& unfinished() noexcept { return unfinished_; }
  /// To be called when UnfinishedMessages::IsLookDue() and everything that was delivered has been read.
  void CutUnfinished();

  /// See AcceptedConnections.
  [[nodiscard]] bool CountTopic(int fd, std::string_view topic, bool subscribed);
  void NoteProof(int fd, std::uint64_t proof) { connections_.NoteProof(fd, proof); }
  [[nodiscard]] bool MaySpeakFor(int fd, SessionId session, std::uint64_t proof);
  [[nodiscard]] bool CountWishes(int fd, SessionId session, std::size_t bytes) {
    return connections_.CountWishes(fd, session, bytes);
  }
  void ForgetWishes(SessionId session) { connections_.ForgetWishes(session); }
  [[nodiscard]] std::vector<SessionId> CollectGivenUp() { return connections_.CollectGivenUp(); }
  void CountSent(int fd, std::size_t bytes) { connections_.CountSent(fd, bytes); }
  void NotePlain(int fd) { connections_.NotePlain(fd); }
  [[nodiscard]] bool NoteSession(int fd, SessionId session);
  void CutStuckPlain(SteadyTime now) { connections_.CutStuckPlain(now); }

 private:
  /// Whether others can connect: not while the socket's file is hidden, or after zmq_unbind.
  enum class Listening { kOpen, kHidden, kClosed };

  bool ReadEvents(std::int32_t& accept_failure);
  void UpdateAll();
  void OnAccepted(int fd);
  void OnAcceptFailed(std::int32_t error);
  void OnHandshakeFailed(int fd, std::int32_t failure);
  void StopIfIpcIsInDanger();
  void Unbind(const std::string& why);
  void ListenAgain(SteadyTime now);
  void Warn(const std::string& text);

  SharedState& shared_;
  Socket& socket_;
  const std::string& bound_;
  Socket monitor_;
  std::atomic<bool> input_{true};
  Listening listening_ = Listening::kOpen;
  int listening_fd_ = -1;
  SteadyTime closed_until_{};
  AcceptedConnections connections_;
  UnfinishedMessages unfinished_;
  std::int32_t handshake_failure_ = 0;  // Of the connection whose end is reported next.
};

}  // namespace hgros::zmq
