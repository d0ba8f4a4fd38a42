#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>

#include "hgros/base/ids.hpp"
#include "transport/peer_registry.hpp"

namespace hgros::zmq {

/// The CURVE key that each session id belongs to: the one over which the id came first. So no other program can speak
/// in the name of that session, even if its key is allowed.
///
/// Thread safety: none; it belongs to the leading thread.
class SessionKeys {
 public:
  /// `peers` outlives it. `own_key` is the key of session `self`.
  SessionKeys(const PeerRegistry& peers, SessionId self, std::string own_key);
  /// False if the session belongs to another key. Otherwise it belongs to `key` from now on.
  [[nodiscard]] bool Claim(SessionId session, std::string_view key);

 private:
  // A limit against clients that invent sessions. Above it, sessions that are not connected are forgotten.
  static constexpr std::size_t kMaxSessions = 8192;

  const PeerRegistry& peers_;
  const SessionId self_;
  std::unordered_map<SessionId, std::string> owners_;
};

}  // namespace hgros::zmq
