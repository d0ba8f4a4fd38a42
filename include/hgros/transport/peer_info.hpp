#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/base/session_name.hpp"
#include "hgros/internal/codec/channel_use.hpp"

namespace hgros {

/// A session as seen over one transport.
struct PeerInfo {
  /// For logs and errors: "PROCESS:PID", with "@HOST" if that is another host.
  [[nodiscard]] std::string name() const { return SessionName(process, pid, host); }

  SessionId id;
  std::string process;  ///< Its program's name.
  std::string host;     ///< Its host's name. Only shown, never compared.
  std::int64_t pid = 0;
  std::string endpoint;   ///< The endpoint that we connected to; empty if it connected to us.
  std::string transport;  ///< The transport of its messages: "shared memory" or "ZeroMQ"; set by the session.
  std::string why;        ///< Why that transport was chosen, such as "same host"; set by the session.
};

/// A session and its known channels.
struct SessionChannels {
  PeerInfo session;
  std::vector<ChannelUse> channels;
};

}  // namespace hgros
