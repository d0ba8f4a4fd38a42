#pragma once

#include <optional>
#include <string>

#include "hgros/control.pb.h"
#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// One XSUB socket connected to a publish endpoint of another session, and what ZeroMQ's monitor tells of the
/// connection: whether there is one, and whether the other side greets like a session.
///
/// Thread safety: none; the endpoint's mutex guards it. The descriptors may be polled without it.
/// Invariants: while the other side is plain it is connected, and it has sent no Welcome since.
class PublisherConnection {
 public:
  /// Connects. Throws Error.
  PublisherConnection(SharedState& shared, const SubscribeEndpoint& endpoint);

  [[nodiscard]] const std::string& endpoint() const noexcept { return endpoint_; }
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

  /// Reads what the monitor has to tell. True if a connection has ended.
  [[nodiscard]] bool ReadMonitor();
  /// The other side has sent a Welcome.
  void SetWelcomed() noexcept;
  /// The other side can be reached, whether the monitor has told so or not.
  void SetConnected() noexcept;

  /// True if the other side is taken for a plain publisher from here on: it was connected long enough without a
  /// Welcome.
  [[nodiscard]] bool TurnPlain(SteadyTime now);
  /// Connects again where ZeroMQ does not, and logs it if there has been no connection for a while.
  void Tick(SteadyTime now);
  /// When Tick() or TurnPlain() must be called next.
  [[nodiscard]] std::optional<SteadyTime> Deadline() const;
  /// Ends the connection; Tick() makes a new one.
  void Abort();
  void Close(int linger_ms);

 private:
  void LogUnreachable();

  SharedState& shared_;
  const std::string endpoint_;
  Socket socket_;
  Socket monitor_;
  int fd_ = -1;
  int monitor_fd_ = -1;
  bool connected_ = false;
  bool welcomed_ = false;
  bool plain_ = false;
  SteadyTime connected_since_{};
  // Disconnected, and ZeroMQ has not said that it will try again. After a breach of its protocol (another program had
  // the publisher's port) it never does.
  std::optional<SteadyTime> given_up_since_;
  // Since when there is no connection; none once that was logged.
  std::optional<SteadyTime> unreached_since_ = std::chrono::steady_clock::now();
  int handshake_failure_ = 0;  // The most telling failure event since the last connection.
};

}  // namespace hgros::zmq
