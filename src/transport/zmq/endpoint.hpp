#pragma once

#include <string>
#include <string_view>

#include "transport/zmq/socket.hpp"

namespace hgros::zmq {

/// `endpoint` with its scheme: "*:5556" means "tcp://*:5556". Throws Error for a scheme other than tcp and ipc and
/// for an ipc path longer than the 107 bytes a unix socket's name may have.
[[nodiscard]] std::string FullEndpoint(std::string_view endpoint);

/// Binds, and throws Error naming the endpoint and what to do if that fails. ZeroMQ itself would silently take an ipc
/// path away from a process that listens there: that is refused here; a path left over from a dead one is taken.
void BindOrThrow(Socket& socket, const std::string& endpoint);

/// Stops accepting connections, and returns when that is so: from then on another may bind the endpoint. What was sent
/// to those connected still has the socket's linger time.
void Unbind(Context& context, Socket& socket, const std::string& bound) noexcept;

/// Closes the connection that `frame` came over, if it still is one to the endpoint `bound`. Its other side sees it end
/// and may connect again.
void HangUp(Message& frame, std::string_view bound) noexcept;

}  // namespace hgros::zmq
