#pragma once

#include <future>
#include <optional>
#include <string>
#include <utility>

#include "hgros/control.pb.h"
#include "transport/zmq/connection.hpp"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"
#include "transport/zmq/unread_bytes.hpp"

namespace hgros::zmq {

/// One XSUB socket connected to a publish endpoint of another session, and the state of its connection by ZeroMQ's
/// monitor: whether there is one, and whether the other side greets like a session.
///
/// Thread safety: none; the endpoint's mutex guards it. The descriptors may be polled without it.
/// Invariants: while the other side counts as plain, it is connected and has sent no Welcome since then.
class PublisherConnection {
 public:
  /// How often a session may come over one connection within 10 s. Each is reported to the program, and other threads
  /// forget what it had. A program that starts again makes a new connection.
  static constexpr int kMostSessions = 16;

  /// Connects. Throws Error.
  PublisherConnection(SharedState& shared, const SubscribeEndpoint& endpoint);

  [[nodiscard]] const std::string& endpoint() const noexcept { return endpoint_; }
  /// The KeyText() of the other side; empty without keys.
  [[nodiscard]] const std::string& server_key() const noexcept { return server_key_; }
  /// With keys, and the other side's is one of those that may subscribe here.
  [[nodiscard]] bool trusted() const noexcept { return trusted_; }
  [[nodiscard]] Socket& socket() noexcept { return socket_; }
  [[nodiscard]] int fd() const noexcept { return fd_; }
  [[nodiscard]] int monitor_fd() const noexcept { return monitor_fd_; }
  [[nodiscard]] bool connected() const noexcept { return connected_; }
  /// A Welcome has come since it was connected.
  [[nodiscard]] bool welcomed() const noexcept { return welcomed_; }
  /// The other side is a plain publisher, as far as we know.
  [[nodiscard]] bool plain() const noexcept { return plain_; }

  void SubscribeTopic(std::string topic, bool subscribe);
  void Send(const wire::Control& control);
  /// Whether the other side has not read for long what was sent, since the last call.
  [[nodiscard]] bool CollectUnread() noexcept { return std::exchange(too_much_unread_, false); }

  /// Reads the monitor's events. True if a connection has ended.
  [[nodiscard]] bool ReadMonitor();
  /// Whether an attempt to connect has failed since the last call.
  [[nodiscard]] bool CollectFailure() noexcept { return std::exchange(failed_, false); }
  /// The descriptor of a new connection since the last call; -1 if it has ended again.
  [[nodiscard]] std::optional<int> CollectConnection() noexcept { return std::exchange(new_connection_, {}); }
  /// The other side has sent a Welcome.
  void SetWelcomed() noexcept;
  /// A session comes. False if that happens too often.
  [[nodiscard]] bool NoteSession() noexcept;
  /// The other side can be reached, even if the monitor has not reported it yet.
  void SetConnected() noexcept;

  /// True if the other side counts as a plain publisher from here on: it was connected long enough without a Welcome.
  [[nodiscard]] bool TurnPlain(SteadyTime now);
  /// Connects again in cases in which ZeroMQ does not, and logs if there was no connection for a while.
  void Tick(SteadyTime now);
  /// When Tick() or TurnPlain() must be called next.
  [[nodiscard]] std::optional<SteadyTime> Deadline() const;
  /// Whether ZeroMQ, here or there, reads no more of the connection, though it stays: after wrong bytes, with keys.
  /// `heard`: when something came from the publisher. To be called once per heartbeat.
  [[nodiscard]] bool IsLeftAlone(SteadyTime now, SteadyTime heard);
  /// Ends the connection; Tick() makes a new one after `pause`.
  void Abort(std::chrono::milliseconds pause = {});
  void Close(int linger_ms);

 private:
  void LogUnreachable();
  void NoteConnection(int fd) noexcept;

  SharedState& shared_;
  const std::string endpoint_;
  const std::string server_key_;
  const bool trusted_;
  Socket socket_;
  Socket monitor_;
  int fd_ = -1;
  int monitor_fd_ = -1;
  bool connected_ = false;
  bool welcomed_ = false;
  bool plain_ = false;
  SteadyTime connected_since_{};
  // Disconnected, and ZeroMQ has not reported that it will try again. It never does after a breach of its protocol,
  // for example if another program had the publisher's port.
  std::optional<SteadyTime> given_up_since_;
  SteadyTime paused_until_{};
  // The time since which there is no connection; none after that was logged.
  std::optional<SteadyTime> unreached_since_ = std::chrono::steady_clock::now();
  bool reported_ = false;      // That there is none was logged.
  int handshake_failure_ = 0;  // The most specific failure event since the last connection.
  const bool logs_;
  bool failed_ = false;
  std::optional<int> new_connection_;
  int tcp_ = -1;  // The descriptor of the connection; -1: none.
  Progress progress_;
  SteadyTime reading_at_{};
  SteadyTime sessions_since_{};
  int sessions_ = 0;  // That have come over this connection since then.
  UnreadBytes unread_;
  bool too_much_unread_ = false;
  std::future<void> lookup_;  // Looks for the host's address: a name server may take long to answer.
};

}  // namespace hgros::zmq
