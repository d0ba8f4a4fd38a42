#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

inline constexpr std::string_view kIpc = "ipc://";
inline constexpr std::string_view kTcp = "tcp://";

/// `endpoint` with its scheme: "*:5556" means "tcp://*:5556". Throws Error for a scheme other than tcp and ipc and for
/// an ipc path longer than the 107 bytes a unix socket's name may have.
[[nodiscard]] std::string FullEndpoint(std::string_view endpoint);

/// Lets the socket use IPv6 if the endpoint has such an address. For names and "*" it uses IPv4.
void SetFamily(Socket& socket, const std::string& endpoint);

/// Binds. If that fails it throws Error, which names the endpoint and what to do. ZeroMQ itself would silently take an
/// ipc path away from a process that listens there. Here this is refused: only the path of a dead process is taken.
void BindOrThrow(Socket& socket, const std::string& endpoint);

/// The host of a tcp endpoint if that is a name; empty for an address and for other endpoints.
[[nodiscard]] std::string HostNameOf(std::string_view endpoint);

/// Why the system finds no address of the host, for example "Name or service not known"; empty if it finds one. May
/// wait for a name server for several seconds.
[[nodiscard]] std::string ResolveFault(const std::string& host);

/// Closes a socket that listens, and returns when another socket may bind the endpoint. Messages to connected peers are
/// still sent within the linger time.
void CloseListening(Context& context, Socket& socket, int linger_ms) noexcept;

/// Keeps new connections away from an ipc endpoint and leaves the others alone: the socket's file gets another name.
/// False if that is impossible, for example in the abstract namespace.
[[nodiscard]] bool HidePath(const std::string& bound);
/// Ends that. Throws Error.
void ShowPath(const std::string& bound);

/// Accepts and closes all connections that wait at a listening socket, even if this process can open no more files.
/// Their programs connect again later. False if that is impossible.
[[nodiscard]] bool TurnAwayWaiting(int listening) noexcept;

}  // namespace hgros::zmq
