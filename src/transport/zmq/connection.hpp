#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

// Queries and commands for one connection of ZeroMQ, by its descriptor.

/// For connections that are accepted at this tcp socket from now on, the kernel drops resets (docs/decisions/0050), and
/// forgets them, and what they still send, as soon as ZeroMQ closes them. Nothing if that is impossible.
void IgnoreResets(int listening) noexcept;
/// Begins or ends to drop them for the connection with this descriptor of ZeroMQ, if it is one to the endpoint.
void SetIgnoresResets(int named, std::string_view bound, bool ignores) noexcept;
/// What that connection sends shall arrive from now on, even if ZeroMQ closes it soon.
void KeepWhenClosed(int named, std::string_view bound) noexcept;

/// ZeroMQ reads a connection that is not full much sooner. With keys, libzmq 4.3.4 may leave one alone over which wrong
/// bytes came, for ever (docs/decisions/0050).
inline constexpr std::chrono::seconds kLeftAloneAfter{5};

/// How far the other side of a tcp connection has got what was sent.
struct Progress {
  std::uint64_t acknowledged = 0;  ///< Bytes.
  bool waits = false;              ///< Something is on its way, or waits for room.
  std::uint64_t read = 0;          ///< Bytes that ZeroMQ has read, if `ended` or `unread`.
  bool ended = false;              ///< Nothing more comes from the other side, or the kernel has closed it.
  bool unread = false;             ///< Something has come that ZeroMQ has not read, if that was asked.
  bool unanswered = false;         ///< That was sent several times, or the kernel has asked, and nothing came back.
};
/// None if that is not known. `asks_unread`: costs one more system call.
[[nodiscard]] std::optional<Progress> ProgressOf(int fd, bool asks_unread) noexcept;

/// How many bytes have come over a tcp connection; none if the system does not say.
[[nodiscard]] std::optional<std::uint64_t> BytesReceived(int fd) noexcept;

/// The bytes that the other side of a tcp connection has acknowledged; none if that is not known.
[[nodiscard]] std::optional<std::uint64_t> BytesAcknowledged(int fd) noexcept;

/// The bytes that ZeroMQ has read from a tcp connection; none if that is not known.
[[nodiscard]] std::optional<std::uint64_t> BytesRead(int fd) noexcept;

/// Closes the connection that `frame` came over, if it is still a connection to the endpoint `bound`. The other side
/// sees it end and may connect again.
void HangUp(Message& frame, std::string_view bound) noexcept;
/// The same for the connection with this descriptor of ZeroMQ.
void HangUp(int named, std::string_view bound) noexcept;

}  // namespace hgros::zmq
